"""Settings and high-precision values that several tests share."""

import fcntl
import os
import signal
from itertools import pairwise
from pathlib import Path

import mpmath as mp
import pytest
from hypothesis import settings
from minimal_build import FINISHED_BUILD, RESULTS
from repository import ROOT
from workflow_tree import Tree

# The same examples every time: a failure must be found again. No deadline, as the first call
# compiles; no database in the tree.
settings.register_profile("rockdamp", derandomize=True, deadline=None, database=None)
settings.load_profile("rockdamp")

# A shell's background job ignores Ctrl-C, and so would every process that a test starts and
# interrupts.
signal.signal(signal.SIGINT, signal.default_int_handler)

# Where several processes share the processors, further threads only wait for each other; those of
# BLAS burn time while they do. NumPy reads this when a test first imports it.
if "PYTEST_XDIST_WORKER" in os.environ:
    for threads in (
        "NUMBA_NUM_THREADS",
        "OPENBLAS_NUM_THREADS",
        "MKL_NUM_THREADS",
        "BLIS_NUM_THREADS",
    ):
        os.environ.setdefault(threads, "1")

# These take minutes, so they go first: no process is left alone with one of them at the end.
LONG = ("tests/workflow/", "tests/documents/test_pages")


def pytest_collection_modifyitems(items):
    items.sort(key=lambda item: not item.nodeid.startswith(LONG))


def areas_under(corners, force, end):
    """Ends of the branches up to `end`, and a function for the area under the curve from a point
    back to another.
    """
    k1, ks = force[1] / corners[1], force[2] / (corners[3] - corners[2])
    ends = [*(x for x in corners if x < end), end]

    def area(high, d):  # from high - d to high, both on one branch
        if high <= corners[1]:
            return k1 * d * (2 * high - d) / 2
        if high <= corners[2]:
            return force[1] * d
        return ks * d * (2 * (corners[3] - high) + d) / 2

    return ends, area


@pytest.fixture(scope="session")
def minimal(tmp_path_factory, worker_id):
    """Folder of the minimal results; tests/support/minimal_build.py makes and reuses it."""
    if FINISHED_BUILD in os.environ:
        return Path(os.environ[FINISHED_BUILD]).resolve()
    base = tmp_path_factory.getbasetemp()
    folder = base if worker_id == "master" else base.parent
    with open(folder / "build.lock", "w", encoding="utf-8") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)  # one process builds, the others wait
        run = Tree(ROOT).snakemake("--nolock")
    assert run.returncode == 0, run.stdout + run.stderr
    return ROOT / RESULTS


@pytest.fixture(scope="session")
def quarter_period():
    """Integral_0^x0 dx/sqrt(2 (V(x0) - V(x))) by mpmath, for the curve drawn through four corners
    (x, f).
    """

    def quadrature(corners, force, x0):
        ends, area = areas_under(corners, force, x0)
        total = outer = mp.mpf(0)
        for low, high in zip(ends[-2::-1], ends[:0:-1], strict=True):
            # In s = sqrt(high - x) the integrand is smooth at the turning point too.
            total += mp.quad(
                lambda s, high=high, outer=outer: 2 * s / mp.sqrt(2 * (outer + area(high, s * s))),
                [0, mp.sqrt(high - low)],
            )
            outer += area(high, high - low)
        return total

    return quadrature


@pytest.fixture(scope="session")
def stored_energy():
    """V(x), summed from the areas under the curve drawn through four corners (x, f)."""

    def energy(corners, force, x):
        ends, area = areas_under(corners, force, x)
        return sum(area(high, high - low) for low, high in pairwise(ends))

    return energy
