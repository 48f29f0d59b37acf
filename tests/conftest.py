"""Settings of all tests, and the minimal build."""

import fcntl
import os
import signal
from pathlib import Path

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
