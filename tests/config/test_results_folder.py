"""The folder of the results is theirs alone, and can be written."""

import os
import shutil
import subprocess

import pytest

from rockdamp.config.files import PARTS, require_folders, require_own_folder, require_writable
from rockdamp.errors import InputError


@pytest.fixture
def tree(tmp_path, monkeypatch):
    """A project with a few of its parts, in which the run stands."""
    place = tmp_path / "project"
    for part in ("src/rockdamp", "docs", "results", ".git"):
        (place / part).mkdir(parents=True)
    monkeypatch.chdir(place)
    return place


@pytest.mark.parametrize("folder", ["results/minimal", "mine", "../elsewhere"])
def test_a_folder_of_its_own_is_allowed(tree, folder):
    require_own_folder(folder, tree)


@pytest.mark.parametrize(
    ("folder", "reason"),
    [
        *((part, f"in '{part}' of the project") for part in PARTS),
        ("results/../docs/figures", "in 'docs' of the project"),
        (".git", "in '.git' of the project"),
        (".", "which holds the project"),
        ("/", "which holds the project"),
    ],
)
def test_a_folder_of_the_project_is_refused(tree, folder, reason):
    with pytest.raises(InputError) as caught:
        require_own_folder(folder, tree)
    assert f"results is {folder!r}, {reason}" in str(caught.value)


@pytest.mark.skipif(shutil.which("git") is None, reason="there is no git")
def test_a_folder_with_files_that_git_tracks_is_refused(tree, tmp_path):
    thesis = tmp_path / "thesis"
    (thesis / "figures").mkdir(parents=True)
    (thesis / "figures/fig1.pdf").write_text("mine", encoding="utf-8")
    subprocess.run(["git", "init", "-q"], cwd=thesis, check=True)
    require_own_folder(thesis, tree)
    subprocess.run(["git", "add", "."], cwd=thesis, check=True)
    for folder in (thesis, thesis / "figures"):
        with pytest.raises(InputError, match="where git tracks '.*fig1.pdf'; results need a folder of their own"):
            require_own_folder(folder, tree)
    require_own_folder(thesis / "new", tree)


def test_the_readme_of_the_results_alone_may_be_tracked(tree):
    shutil.rmtree(tree / ".git")
    subprocess.run(["git", "init", "-q"], cwd=tree, check=True)
    (tree / "results/README.md").touch()
    subprocess.run(["git", "add", "."], cwd=tree, check=True)
    require_own_folder("results", tree)
    (tree / "results/damping_force.nc").touch()
    subprocess.run(["git", "add", "."], cwd=tree, check=True)
    with pytest.raises(InputError, match="where git tracks 'damping_force.nc'"):
        require_own_folder("results", tree)


def test_a_folder_that_is_there_or_can_be_made_is_writable(tmp_path):
    (tmp_path / "figures").mkdir()
    require_writable(tmp_path, "the results")
    require_writable(tmp_path / "of/a/new/one", "the results")
    require_folders(tmp_path / "of/a/new/one", ["", "match"], "the results")
    assert os.listdir(tmp_path) == ["figures"]


@pytest.mark.parametrize("at", ["logs", "logs/minimal/match"])
@pytest.mark.parametrize("broken", [False, True], ids=["file", "link"])
def test_a_file_or_a_broken_link_where_a_folder_must_be_is_named(at, broken, tmp_path):
    path = tmp_path / at
    path.parent.mkdir(parents=True, exist_ok=True)
    if broken:
        path.symlink_to(tmp_path / "nowhere")
    else:
        path.touch()
    with pytest.raises(InputError, match=rf"{at} cannot be written; the logs need a folder"):
        require_folders(tmp_path / "logs/minimal", ["match", "figures"], "the logs")
    path.unlink()
    (tmp_path / "elsewhere").mkdir()
    path.symlink_to(tmp_path / "elsewhere")
    require_folders(tmp_path / "logs/minimal", ["match", "figures"], "the logs")
