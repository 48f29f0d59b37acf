"""Machine code of the solvers: its cache, and the messages about it.

The tests run programs with a copy of the package, and edit or damage that.
"""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import rockdamp
from rockdamp.solvers.machine_code import FIRST_COMPILATION, NO_FOLDER

DECAYS = """
import sys
import rockdamp as rd
for model in sys.argv[1:]:
    curve, damping = rd.TrilinearCurve(0.04, 0.85), rd.Damping(model, 0.5)
    if model == "CR":
        print(rd.exact_history(curve, damping, [2.9], release_amplitude=0.5).displacement)
    else:
        run = rd.simulate(curve, damping, release_amplitude=0.5, step=0.01, steps=300)
        print(run.displacement.sum())
"""
SMALL_FUNCTION = """
from rockdamp.solvers import kernel, machine_code
assert machine_code.compile_cached(kernel.predict)(1.0, 2.0, 0.0, 0.5) == 2.0
"""
DECAY = "decay --a1 0.04 --b1 0.85 --damping-model CDC --damping-ratio 0.05 --json".split()


class Package:
    """A copy of the package with a folder of machine code."""

    def __init__(self, place, left_out="__pycache__"):
        self.source = place / "rockdamp"
        self.cache = place / "cache"
        original = Path(rockdamp.__file__).parent
        shutil.copytree(original, self.source, ignore=shutil.ignore_patterns(left_out))
        self.environment = os.environ | {
            "PYTHONPATH": str(place),
            "NUMBA_CACHE_DIR": str(self.cache),
        }
        self.environment.pop("NUMBA_DISABLE_JIT", None)

    def run(self, *command):
        return subprocess.run(
            [sys.executable, *command], env=self.environment, capture_output=True, text=True
        )

    def decays(self, *models):
        """Return what decays with several dampers print: CR's by the exact solver."""
        run = self.run("-c", DECAYS, *models)
        assert run.returncode == 0, run.stderr
        return run.stdout.split()

    def edit(self, name, old, new):
        file = self.source / f"solvers/{name}.py"
        code = file.read_text(encoding="utf-8")
        assert code.count(old) == 1
        file.write_text(code.replace(old, new), encoding="utf-8")


@pytest.fixture
def package(tmp_path):
    return Package(tmp_path)


@pytest.fixture(scope="module")
def compiled(tmp_path_factory):
    """A package that has compiled CDC, for tests that leave its files as they found them."""
    package = Package(tmp_path_factory.mktemp("compiled"))
    first = package.run("-m", "rockdamp", *DECAY)
    assert first.returncode == 0
    package.first_messages = first.stderr
    return package


def test_cached_and_new_code_are_not_mixed_up(compiled):
    (cdc,) = compiled.decays("CDC")
    mixed = compiled.decays("CDC", "SDR")  # SDR is compiled beside the cached code of CDC
    assert mixed[0] == cdc
    assert compiled.decays("CDC", "SDR") == mixed


def test_edited_exact_solver_finds_no_old_code(tmp_path):
    """The edit is in a function that the compiled entry calls.

    The copy has the machine code that lies beside the sources, and compiles it only after the edit.
    """
    package = Package(tmp_path, left_out="*.pyc")
    del package.environment["NUMBA_CACHE_DIR"]
    displacement = package.decays("CR")
    package.edit("exact", "return e\n    level", "return 0.5 * e\n    level")
    assert package.decays("CR") != displacement


def test_only_the_first_compilation_is_announced(compiled):
    assert compiled.first_messages.splitlines() == [FIRST_COMPILATION]
    assert not compiled.run("-m", "rockdamp", *DECAY).stderr


def test_without_a_writable_folder_it_says_so_once_and_runs(package):
    package.environment |= {"NUMBA_CACHE_DIR": "/dev/null/cache", "HOME": "/dev/null"}
    package.environment.pop("XDG_CACHE_HOME", None)
    (package.source / "solvers/__pycache__").write_text("no folder", encoding="utf-8")
    run = package.run("-c", DECAYS + SMALL_FUNCTION, "CDC")
    assert run.returncode == 0
    assert run.stderr.splitlines() == [NO_FOLDER]


@pytest.mark.parametrize(
    ("suffix", "start"), [("nbi", b""), ("nbc", b"damage")], ids=["cut", "scribbled"]
)
def test_damaged_machine_code_is_named(compiled, suffix, start):
    files = list(compiled.cache.glob(f"*/kernel.*.{suffix}"))
    contents = [file.read_bytes() for file in files]
    for file, content in zip(files, contents, strict=True):
        file.write_bytes(start + content[len(start) : 100])
    run = compiled.run("-m", "rockdamp", *DECAY)
    for file, content in zip(files, contents, strict=True):
        file.write_bytes(content)
    assert run.returncode == 2
    (line,) = run.stderr.splitlines()
    pattern = Path(line.partition("; delete ")[2])
    assert set(files) & set(pattern.parent.glob(pattern.name))


def test_edited_kernel_finds_no_old_code(compiled):
    """Last, as the edit stays."""
    sums = compiled.decays("CDC")
    compiled.edit("kernel", "half_v = v + 0.5 * h * a", "half_v = v + 0.6 * h * a")
    assert compiled.decays("CDC") != sums
