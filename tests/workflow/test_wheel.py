"""The wheel by itself: what it installs answers with no repository around it."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from repository import ROOT

PIP = (sys.executable, "-m", "pip", "--disable-pip-version-check", "--quiet", "--no-input")
OFFLINE = ("--no-index", "--no-deps")


@pytest.fixture(scope="module")
def installed(tmp_path_factory):
    """The wheel's content in a folder of its own, before the environment's on the path."""
    folder = tmp_path_factory.mktemp("wheel")
    subprocess.run(
        [*PIP, "wheel", *OFFLINE, "--no-build-isolation", "--wheel-dir", folder, ROOT], check=True, capture_output=True
    )
    (wheel,) = folder.glob("rockdamp-*.whl")
    subprocess.run([*PIP, "install", *OFFLINE, "--target", folder / "site", wheel], check=True, capture_output=True)
    ours, solvers = ROOT / "src/rockdamp/solvers", folder / "site/rockdamp/solvers"
    for compiled in (ours / "__pycache__").glob("*.nb[ic]"):  # Numba takes it where the sources have the same date
        shutil.copy(compiled, solvers / "__pycache__")
    for kernel in solvers.glob("*_kernel.py"):
        shutil.copystat(ours / kernel.name, kernel)
    return folder / "site"


def run(installed, *arguments):
    environment = {**os.environ, "PYTHONPATH": str(installed)}
    process = subprocess.run(
        [sys.executable, *arguments], cwd=installed.parent, env=environment, capture_output=True, text=True, check=True
    )
    return process.stdout


def test_it_answers_as_the_repository_does(installed):
    code = "import rockdamp; print(rockdamp.__file__)"
    assert Path(run(installed, "-c", code).strip()).is_relative_to(installed)
    options = "equivalent --restitution 0.85 --a1 0.04 --b1 0.85 --json".split()
    found = json.loads(run(installed, "-m", "rockdamp", *options))
    from rockdamp.equivalence.equivalent import equivalent
    from rockdamp.mechanics.curve import TrilinearCurve

    # Another process may have compiled it, so the last bits may differ.
    for one, other in zip(found, equivalent(0.85, TrilinearCurve(0.04, 0.85)), strict=True):
        # A name, and None where the package ships no polynomial, are equal; numbers nearly.
        exact = [key for key, value in other.items() if not isinstance(value, float)]
        assert [one.pop(key) for key in exact] == [other.pop(key) for key in exact]
        assert one == pytest.approx(other, rel=1e-4) and one


def test_it_holds_every_file_that_the_package_reads_and_no_other(installed):
    source, own = ROOT / "src/rockdamp", installed / "rockdamp"
    expected = {path.relative_to(source) for path in source.rglob("*") if path.is_file()}
    found = {path.relative_to(own) for path in own.rglob("*") if path.is_file()}
    compiled = {path for path in expected | found if "__pycache__" in path.parts}
    assert found - compiled == expected - compiled
    kinds = {".yaml", ".csv", ".mplstyle", ".js", ".css", ".j2", ".pyi"}
    assert {path.suffix for path in found - compiled} >= kinds
    assert Path("py.typed") in found
