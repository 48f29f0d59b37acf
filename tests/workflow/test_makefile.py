"""`make` works in its own folder, and removes what was built there and nothing else."""

import shutil
import subprocess

import pytest
from repository import ROOT


@pytest.fixture
def tree(tmp_path):
    """The Makefile alone, in a folder whose name has what shells and make take for something else."""
    place = tmp_path / "a träe $(x) `y`"
    place.mkdir()
    shutil.copy(ROOT / "Makefile", place)
    return place


def make(place, *arguments):
    return subprocess.run(["make", *arguments], cwd=place, capture_output=True, text=True)


def test_clean_keeps_the_readme_of_the_results_and_removes_the_rest(tree):
    (tree / "results/figures").mkdir(parents=True)
    for name in ("README.md", "damping_force.nc", ".damping_force.nc.1.part", "figures/fig1.png"):
        (tree / "results" / name).touch()
    run = make(tree, "clean")
    assert run.returncode == 0, run.stderr
    assert [path.name for path in (tree / "results").rglob("*")] == ["README.md"]


def test_clean_from_elsewhere_touches_nothing(tree, tmp_path):
    elsewhere = tmp_path / "elsewhere"
    (elsewhere / "results").mkdir(parents=True)
    (elsewhere / "results/thesis.txt").touch()
    for arguments in (["-f", str(tree / "Makefile"), "clean"], ["-f", f"../{tree.name}/Makefile", "clean"]):
        run = make(elsewhere, *arguments)
        assert run.returncode != 0
        assert "run make in the folder of the Makefile, as in: make -C FOLDER clean" in run.stderr
    assert (elsewhere / "results/thesis.txt").exists()
    (tree / "results").mkdir()
    (tree / "results/damping_force.nc").touch()
    assert make(elsewhere, "-C", str(tree), "clean").returncode == 0
    assert not (tree / "results/damping_force.nc").exists()


@pytest.mark.parametrize("name", ["a$x", "a:b"])
def test_a_folder_whose_name_a_shell_would_expand_is_refused_before_anything_is_made(tmp_path, name):
    place = tmp_path / name
    place.mkdir()
    for file in ("Makefile", "requirements.lock", "pyproject.toml"):
        shutil.copy(ROOT / file, place)
    run = make(place, "setup")
    assert run.returncode != 0
    assert 'this folder, or one above it, has a line break or one of $ ` " \\ : in its name' in run.stderr
    assert not (place / ".venv").exists()
