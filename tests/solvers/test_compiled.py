"""Machine code from the cache: it is found by a copied tree, is never old, and a damaged file ends in one line."""

import os
import shutil
import subprocess
import sys
import warnings
from pathlib import Path

import pytest
from numba.core.dispatcher import Dispatcher

from rockdamp.errors import InputWarning
from rockdamp.pipeline.compile_all import compile_all
from rockdamp.solvers import compiled, newmark_kernel, peaks_kernel
from rockdamp.vocabulary import MODELS, VISCOUS_MODELS

EACH = """
import sys
import numpy as np
import rockdamp as rd
curve = rd.TrilinearCurve(0.04, 0.85)
for model in sys.argv[1:]:
    damping = rd.Damping.from_values(model, restitution=0.9, damping_ratio=0.05)
    print(repr(float(np.abs(rd.solve(curve, damping, release_amplitude=0.5, step=0.01, steps=300).peak_tau))))
    run = rd.solve(curve, damping, release_amplitude=0.5, step=0.01, steps=300, store_every=1)
    print(model, repr(float(np.abs(run.displacement).sum())))
"""


def tree(place):
    """A copy of the package, with none of its compiled code."""
    shutil.copytree(compiled.PACKAGE, place / "rockdamp", ignore=shutil.ignore_patterns("__pycache__"))
    return place


def run(place, *models, check=True, **environment):
    dropped = ("NUMBA_DISABLE_JIT", "NUMBA_CACHE_DIR")
    kept = {key: value for key, value in os.environ.items() if key not in dropped}
    environment = {**kept, "PYTHONPATH": str(place), "PYTHONDONTWRITEBYTECODE": "1", **environment}
    command = [sys.executable, "-c", EACH, *models]
    return subprocess.run(command, env=environment, capture_output=True, text=True, check=check)


def files(place):
    return {path.relative_to(place): path.stat().st_mtime_ns for path in place.rglob("*.nb[ic]")}


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    """A tree with the compiled code of one damper, and what it computes."""
    place = tree(tmp_path_factory.mktemp("built"))
    return place, run(place, "CDC").stdout


@pytest.fixture
def copy(built, tmp_path):
    """A copy of that tree, its compiled code included."""
    return Path(shutil.copytree(built[0], tmp_path / "copy"))


def test_a_cache_in_order_is_used_and_a_copied_tree_finds_its_code(built, copy):
    before = files(copy)
    assert len(before) == 2
    assert run(copy, "CDC").stdout == built[1]
    assert files(copy) == before


def test_an_edited_formula_finds_no_old_code_and_an_edit_of_another_damper_leaves_it(built, copy):
    before = files(copy)
    with (copy / "rockdamp/mechanics/damping/cdr.py").open("a", encoding="utf-8") as another:
        another.write("# edited\n")
    assert run(copy, "CDC").stdout == built[1] and files(copy) == before
    formula = copy / "rockdamp/mechanics/damping/cdc.py"
    formula.write_text(formula.read_text(encoding="utf-8").replace("return parameters[0]", "return 2 * parameters[0]"))
    assert run(copy, "CDC").stdout != built[1]
    shutil.copy(built[0] / "rockdamp/mechanics/damping/cdc.py", formula)
    assert run(copy, "CDC").stdout == built[1]


DAMPER = str(compiled.PACKAGE / "mechanics/damping/ecd.py")


@pytest.mark.parametrize("source", ["mechanics/trilinear.py", "mechanics/damping/ecd.py"])
def test_the_sources_that_all_share_count_and_the_file_of_ones_own_formula(monkeypatch, source):
    before, path = compiled.digest.__wrapped__(DAMPER), str(compiled.PACKAGE / source)
    sources = compiled.DAMPER_SOURCES if path == DAMPER else compiled.SHARED_SOURCES
    monkeypatch.setitem(sources, path, sources[path] + b"# edited")
    assert compiled.digest.__wrapped__(DAMPER) != before


def test_code_from_the_cache_and_code_just_compiled_do_not_stand_for_each_other(built, copy):
    """A process that finds one damper in the cache and compiles the others gives each its step."""
    models = ("CDC", *VISCOUS_MODELS[1:3])
    mixed = run(copy, *models).stdout
    assert mixed.startswith(built[1]) and len({line.split()[-1] for line in mixed.splitlines()[1::2]}) == 3
    assert run(copy, *models).stdout == mixed  # now all of them from the cache


@pytest.mark.parametrize(("suffix", "kept"), [("nbi", 0), ("nbc", 99)])
def test_a_damaged_file_of_the_cache_ends_in_one_line(copy, suffix, kept):
    (path,) = copy.rglob(f"*.{suffix}")
    path.write_bytes(path.read_bytes()[:kept])
    done = run(copy, "CDC", check=False)
    assert done.returncode == 1
    last = done.stderr.splitlines()[-1]
    assert "InputError: compiled code under" in last and last.endswith("is damaged; `make clean` removes it")


def test_where_no_folder_can_be_written_code_is_compiled_and_not_kept(monkeypatch):
    def refuse(_):
        raise RuntimeError("cannot cache function")

    monkeypatch.setattr(Dispatcher, "enable_caching", refuse)
    compiled._say_that_nothing_is_kept.cache_clear()

    def double(x):
        return 2 * x

    with pytest.warns(InputWarning, match="compiled code is not kept, and each run compiles anew.*NUMBA_CACHE_DIR"):
        assert compiled.compiled(double, double)(3) == 6
    with warnings.catch_warnings():  # it is said once
        warnings.simplefilter("error")
        assert compiled.compiled(double, double)(4) == 8


def test_the_users_folder_is_respected(copy, tmp_path):
    shutil.rmtree(next(copy.rglob("*.nbi")).parent)
    run(copy, "CDC", NUMBA_CACHE_DIR=str(tmp_path / "cache"))
    assert not files(copy) and len(files(tmp_path / "cache")) == 2


def test_all_loops_are_compiled_once_each():
    caches = newmark_kernel.compiled_march, peaks_kernel.compiled_march
    compile_all()
    loops = [cache.cache_info().currsize for cache in caches]
    compile_all()
    assert loops == [cache.cache_info().currsize for cache in caches]
    assert min(loops) > len(MODELS)


def test_copies_for_two_dampers_have_names_of_their_own():
    """By the name that Numba gives to machine code, the inner functions' included."""

    def inner(x):
        return x

    copies = [compiled.specialised((inner,), name)["inner"] for name in ("one", "other")]
    assert [copy.__name__ for copy in copies] == [copy.__qualname__ for copy in copies] == ["inner_one", "inner_other"]
