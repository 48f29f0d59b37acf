"""A damaged file of Numba's cache is compiled again; it neither ends the process nor stays."""

import os
import subprocess
import sys

import pytest
from numba import njit

from rockdamp import kernels
from rockdamp.storage import compiled_cache
from rockdamp.vocabulary import VISCOUS_MODELS

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


def answers(cache, *models):
    """The sum of each model's decay, by a process of its own."""
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(cache)}
    environment.pop("NUMBA_DISABLE_JIT", None)
    command = [sys.executable, "-c", EACH, *models]
    return subprocess.run(command, env=environment, capture_output=True, text=True, check=True).stdout


def test_code_from_the_cache_and_code_just_compiled_do_not_stand_for_each_other(tmp_path, capsys, monkeypatch):
    """A process that finds some dampers in the cache and compiles the others gives each its own step."""
    one, *others = VISCOUS_MODELS[-1], *VISCOUS_MODELS[:2]
    monkeypatch.setattr(sys, "argv", ["", one, *others])
    exec(EACH, {})
    expected = capsys.readouterr().out
    assert len({line.split()[1] for line in expected.splitlines()}) == 3
    answers(tmp_path, one)
    assert answers(tmp_path, one, *others) == expected
    assert answers(tmp_path, one, *others) == expected  # now all of them from the cache


FORMULA = """
from numba import njit
from rockdamp.storage.compiled_cache import checked, digest_of

def plain(x):
    return 2.0 * x

formula = checked(njit(cache=True)(plain), digest_of(__file__))
"""

EDITED = """
import sys
from pathlib import Path
import formula
source = Path(formula.__file__)
source.write_text(source.read_text(encoding="utf-8").replace(*sys.argv[1:]), encoding="utf-8")
print(formula.formula(1.0))
"""


def test_code_of_an_edited_source_is_not_kept_under_the_new_one(tmp_path):
    """A process that imported the file before the edit compiles after it."""
    (tmp_path / "formula.py").write_text(FORMULA, encoding="utf-8")
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path / "cache"), "PYTHONDONTWRITEBYTECODE": "1"}
    environment.pop("NUMBA_DISABLE_JIT", None)

    def answer(*edit):
        command = [sys.executable, "-c", EDITED, *edit]
        run = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=True)
        return float(run.stdout)

    right, wrong = "2.0", "3.0"
    assert answer(right, wrong) == 2.0
    assert answer("", "") == 3.0  # not the code of the right one
    assert answer(wrong, right) == 3.0  # this process had imported the wrong one
    assert answer("", "") == 2.0


def test_the_kernels_code_is_kept_under_the_source_as_it_was_imported(monkeypatch):
    assert kernels.SOURCE == compiled_cache.digest_of(kernels.__file__)
    monkeypatch.setattr(kernels, "SOURCE", "as it was imported")
    compiled = kernels.march.__wrapped__(kernels.constant_at)
    assert compiled._cache._cache_file._source_stamp == "as it was imported"


def closes_over(number, place):
    """A function as the kernel has them: it calls one that closes over another, in a file at `place`."""
    text = f"""
def make(number):
    def inner(x):
        return x * number
    def outer(x):
        return inner(x) + {number}
    return outer
outer = make({number})
"""
    names = {}
    exec(compile(text, str(place), "exec"), names)
    return names["outer"]


def test_code_is_kept_by_what_a_function_computes_and_not_by_its_place():
    """A copied tree compiles nothing again; a formula that is another is never taken for it."""

    def meant(function):
        return repr(compiled_cache._meaning(function))

    one = closes_over(2.0, "/here/kernels.py")
    assert meant(one) == meant(closes_over(2.0, "/there/kernels.py")) == meant(njit(one))
    assert meant(one) != meant(closes_over(3.0, "/here/kernels.py"))
    inner = one.__closure__[0].cell_contents.__closure__[0]
    before = meant(one)
    inner.cell_contents = 2.5  # two functions down
    assert meant(one) != before


AGAIN = """
import runpy, shutil, sys
from pathlib import Path
script, place, *damaged = sys.argv[1:]
for file in damaged:
    shutil.copy(file, place)
    runpy.run_path(script)
    assert Path(place).read_bytes() != Path(file).read_bytes(), file  # mended on the disk too
if not damaged:
    runpy.run_path(script)
"""


LOADED = f"{AGAIN}print('numba.np.arraymath' in sys.modules)\n"


def run(folder, place="", *damaged, program=AGAIN):
    """What a process prints that calls the function, once or after each damaged file is put in the place of another."""
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(folder)}
    environment.pop("NUMBA_DISABLE_JIT", None)
    command = [sys.executable, "-c", program, *map(str, (folder / "script.py", place, *damaged))]
    done = subprocess.run(command, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert "Aborted" not in done.stderr
    return done.stdout.splitlines()


@pytest.fixture(scope="module")
def cache(tmp_path_factory):
    """A folder with the code of a function that compiles in no time, as the kernel's are compiled; what it prints."""
    folder = tmp_path_factory.mktemp("numba")
    (folder / "script.py").write_text(SCRIPT, encoding="utf-8")
    return folder, run(folder)


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


def test_code_from_the_cache_runs_without_the_compiler(cache):
    """What Numba compiles with takes a quarter of a second to import: none of it is, where nothing is compiled."""
    folder, expected = cache
    assert run(folder, program=LOADED) == [*expected, "False"]


@pytest.mark.parametrize("suffix", ["nbi", "nbc"])
def test_a_damaged_file_of_the_cache_is_compiled_again(cache, suffix, tmp_path):
    folder, expected = cache
    (place,) = files(folder, suffix)
    whole = place.read_bytes()
    damaged = [tmp_path / name for name in DAMAGES]
    for path in damaged:
        path.write_bytes(DAMAGES[path.name](whole))
    assert run(folder, place, *damaged) == expected * len(damaged)


def test_a_cache_in_order_is_used(cache):
    folder, expected = cache
    before = {path: path.stat().st_mtime_ns for suffix in ("nbi", "nbc") for path in files(folder, suffix)}
    assert run(folder) == expected
    assert {path: path.stat().st_mtime_ns for path in before} == before


@pytest.mark.parametrize("part", ["_save_index", "_save_data"])
def test_two_that_write_at_once_never_leave_the_code_of_one_under_the_name_of_the_other(tmp_path, part):
    """The other writes all of its own before a part of this one: an entry may be lost, none is wrong."""
    one, other = (compiled_cache.CheckedFile(str(tmp_path), "function", "source") for _ in range(2))
    write, at_first = getattr(one, part), one._load_index()

    def late(*content):
        other._load_index = lambda: dict(at_first)  # it had read the index before either wrote
        other.save("other", "code of the other")
        del other._load_index
        write(*content)

    setattr(one, part, late)
    one.save("one", "code of the one")
    setattr(one, part, write)
    for key in ("one", "other"):
        assert one.load(key) in (None, f"code of the {key}")
    for key in ("one", "other"):  # compiled again
        one.save(key, f"code of the {key}")
    assert [other.load(key) for key in ("one", "other")] == ["code of the one", "code of the other"]


def test_code_of_an_earlier_source_goes_away(tmp_path):
    for source in ("source", "source, edited"):
        one = compiled_cache.CheckedFile(str(tmp_path), "function", source)
        assert one.load("key") is None
        one.save("key", f"code of {source}")
        assert one.load("key") == f"code of {source}"
        assert len(list(tmp_path.glob("*.nbc"))) == 1
