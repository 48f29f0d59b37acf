"""A damaged file of Numba's cache is compiled again; it neither ends the process nor stays."""

import os
import shutil
import subprocess
import sys

import pytest
from repository import ROOT

from rockdamp.vocabulary import MODELS

SCRIPT = """
from numba import njit
from rockdamp.storage.compiled_cache import checked, digest_of

def total(count):
    sum = 0.0
    for i in range(count):
        sum += 0.5 * i
    return sum

print(checked(njit(cache=True, fastmath=True)(total), digest_of(__file__))(1000))
"""


EACH = """
import sys
import numpy as np
from rockdamp import free_decay, TrilinearCurve, Damping
for model in sorted(sys.argv[1:]):
    damping = Damping.of(model, restitution=0.9, damping_ratio=0.05)
    print(model, repr(np.abs(free_decay(TrilinearCurve(0.04, 0.85), damping, length=3.0).displacement).sum().item()))
"""


def test_code_from_the_cache_and_code_just_compiled_do_not_stand_for_each_other(tmp_path):
    """A process that finds some dampers in the cache and compiles the others gives each its own step."""

    def answers(cache, *models):
        environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path / cache)}
        environment.pop("NUMBA_DISABLE_JIT", None)
        command = [sys.executable, "-c", EACH, *models]
        return subprocess.run(command, env=environment, capture_output=True, text=True, check=True).stdout

    expected = answers("alone", *MODELS)
    assert len({line.split()[1] for line in expected.splitlines()}) == len(MODELS)
    answers("shared", MODELS[-1], MODELS[0])
    assert answers("shared", *MODELS) == expected
    assert answers("shared", *MODELS) == expected  # now all of them from the cache


EDITED = """
import sys
from pathlib import Path
sys.path.insert(0, sys.argv[1])
import numpy as np
from rockdamp import free_decay, kernels, TrilinearCurve, Damping
source = Path(kernels.__file__)
source.write_text(source.read_text(encoding="utf-8").replace(*sys.argv[2:4]), encoding="utf-8")
decay = free_decay(TrilinearCurve(0.04, 0.85), Damping.cr(0.9), release_amplitude=0.5, length=2.0)
print(np.asarray(decay.displacement).sum())
"""


def test_code_of_an_edited_source_is_not_kept_under_the_new_one(tmp_path):
    """A process that imported the file before the edit compiles after it."""
    shutil.copytree(ROOT / "src", tmp_path / "src", ignore=shutil.ignore_patterns("__pycache__", "*.egg-info"))
    right, wrong = "h -= s", "h -= 0.9 * s"
    assert (ROOT / "src/rockdamp/kernels.py").read_text(encoding="utf-8").count(right) == 1
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path / "cache"), "PYTHONDONTWRITEBYTECODE": "1"}
    environment.pop("NUMBA_DISABLE_JIT", None)

    def answer(*edit):
        command = [sys.executable, "-c", EDITED, str(tmp_path / "src"), *edit]
        return subprocess.run(command, env=environment, capture_output=True, text=True, check=True).stdout

    before = answer(right, wrong)
    after = answer("", "")
    assert after != before  # the wrong step, not the code of the right one
    assert answer(wrong, right) == after  # this process had imported the wrong one
    assert answer("", "") == before


def run(cache):
    """A function that compiles in no time, as the kernel's are compiled."""
    script = cache / "script.py"
    script.write_text(SCRIPT, encoding="utf-8")
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(cache)}
    environment.pop("NUMBA_DISABLE_JIT", None)
    return subprocess.run([sys.executable, str(script)], env=environment, capture_output=True, text=True)


@pytest.fixture(scope="module")
def cache(tmp_path_factory):
    folder = tmp_path_factory.mktemp("numba")
    first = run(folder)
    assert first.returncode == 0, first.stderr
    return folder, first.stdout


def files(folder, suffix):
    found = sorted(path for path in folder.rglob(f"*.{suffix}"))
    assert found
    return found


def flip(place):
    def change(content):
        changed = bytearray(content)
        changed[int(place * len(changed))] ^= 4
        return bytes(changed)

    return change


DAMAGES = {
    "empty": lambda content: b"",
    "cut": lambda content: content[: len(content) // 2],
    "flipped in the middle": flip(0.5),
    "flipped near the end": flip(0.95),
    "longer": lambda content: content + b"1",
    "text": lambda content: b"not a cache",
}


@pytest.mark.parametrize("damage", DAMAGES)
@pytest.mark.parametrize("suffix", ["nbi", "nbc"])
def test_a_damaged_file_of_the_cache_is_compiled_again(cache, suffix, damage):
    folder, expected = cache
    kept = {path: path.read_bytes() for path in files(folder, suffix)}
    for path, content in kept.items():
        path.write_bytes(DAMAGES[damage](content))
    again = run(folder)
    assert (again.returncode, again.stdout) == (0, expected), again.stderr
    assert "Aborted" not in again.stderr
    for path in kept:  # mended on the disk too
        assert path.read_bytes() != DAMAGES[damage](kept[path])


def test_a_cache_in_order_is_used(cache):
    folder, expected = cache
    before = {path: path.stat().st_mtime_ns for suffix in ("nbi", "nbc") for path in files(folder, suffix)}
    assert run(folder).stdout == expected
    assert {path: path.stat().st_mtime_ns for path in before} == before
