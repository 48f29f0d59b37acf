"""A run is a chain of calls of the kernel: however it is cut the bits are the same, and between two it can be ended."""

import signal
import subprocess
import sys
import time

import numpy as np
import pytest

from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.solvers import newmark
from rockdamp.solvers.newmark import solve
from rockdamp.solvers.response import Reference
from rockdamp.vocabulary import MODELS

LANES = 130  # of three blocks
CURVE = TrilinearCurve(np.linspace(0.03, 0.12, LANES), 0.7)
GROUND = np.random.default_rng(5).normal(size=121)
STILL = Reference(np.zeros((2, 601)), case=np.arange(LANES) % 2, checkpoints=[1, 7, 100, 599])


@pytest.mark.parametrize("scheme", ["newmark", "paper"])
@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("size", [7, 350])
def test_a_run_in_slices_has_the_bits_of_one_in_one_piece(monkeypatch, size, model, scheme):
    damping = Damping(model, 0.9 if model == "CR" else 0.05)
    # Of these some collapse, at different steps.
    run = {"load_factor": np.linspace(0.02, 3.0, LANES), "ground_acceleration": GROUND, "substeps": 5}
    run |= {"release_amplitude": 0.3, "step": 0.02, "steps": 600, "store_every": 3}
    run |= {"reference": STILL, "scheme": scheme}
    whole = solve(CURVE, damping, **run)
    assert 0 < whole.outcome.sum() < LANES
    monkeypatch.setattr(newmark, "SLICE", size)
    assert solve(CURVE, damping, **run) == whole
    assert solve(CURVE, damping, **run, threads=2) == whole


def test_a_part_that_fails_ends_the_run_and_stops_the_others():
    told = []

    def advance(part, stopped):
        told.append(stopped)
        if part.start == 0:
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        newmark._in_threads(advance, 64, 1, 2)
    assert len({*told}) == 1 and told[0].is_set()


ENDLESS = """
import numpy as np
import rockdamp as rd
run = {"release_amplitude": np.full(%d, 0.5), "step": 0.001, "threads": %d}
rd.solve(rd.TrilinearCurve(0.04, 0.85), rd.Damping.cr(1.0), steps=1, **run)
print("ready", flush=True)
rd.solve(rd.TrilinearCurve(0.04, 0.85), rd.Damping.cr(1.0), steps=10**9, **run)
"""


@pytest.mark.parametrize(("lanes", "threads"), [(1, 1), (1000, 2)])
def test_a_run_of_hours_can_be_interrupted(lanes, threads):
    process = subprocess.Popen(
        [sys.executable, "-c", ENDLESS % (lanes, threads)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    try:
        assert process.stdout.readline() == "ready\n"
        time.sleep(0.5)
        process.send_signal(signal.SIGINT)
        assert "KeyboardInterrupt" in process.communicate(timeout=30)[1]
    finally:
        process.kill()
        process.communicate()
