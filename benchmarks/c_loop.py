"""The march of peaks of scheme.c, called by ctypes."""

from __future__ import annotations

import ctypes
import subprocess
import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
from walls import STEP, STEPS, SUBSTEPS, Walls

FLAGS = ("-O3", "-march=native", "-ffast-math")
LANES = 64
# Members of the struct Block of scheme.c, in their order.
ROWS = ("x", "v", "a", "peak", "k1", "b1", "ks", "a1", "a2", "a3", "factor", "e", "c")


def compile_scheme() -> ctypes.CDLL:
    """Compile scheme.c into a temporary folder and load it."""
    with tempfile.TemporaryDirectory() as folder:
        library = Path(folder) / "scheme.so"
        source = Path(__file__).with_name("scheme.c")
        subprocess.run(
            ["gcc", *FLAGS, "-shared", "-fPIC", source, "-o", library, "-lm"], check=True
        )
        return ctypes.CDLL(str(library))  # what is loaded outlives the file


def c_peaks(library: ctypes.CDLL, walls: Walls) -> Callable[[], np.ndarray]:
    """Return a function that runs the walls by C and returns their peaks.

    The number of walls is a multiple of LANES.
    """
    model = walls.damping.model
    _, (scale, reach, _) = walls.damping.kernel_arguments(walls.curve)
    if model == "CR":
        reach = scale  # e
        scale = 0.0
    start_acceleration = walls.factor * walls.ground[0]
    state = (0.0, 0.0, start_acceleration, 0.0)
    columns = (*state, *walls.curve.parameters(), walls.factor, reach, scale)
    flat = np.stack([np.broadcast_to(column, walls.factor.size) for column in columns])
    blocks_of_rows = flat.reshape(len(ROWS), -1, LANES).swapaxes(0, 1)
    start = np.ascontiguousarray(blocks_of_rows, dtype=float)
    blocks = start.copy()
    ground = np.ascontiguousarray(walls.ground)
    march = getattr(library, f"march_{model}")
    pointer = ctypes.c_void_p
    integer = ctypes.c_long
    march.argtypes = [pointer, integer, pointer, integer, integer, ctypes.c_double]

    def run() -> np.ndarray:
        np.copyto(blocks, start)
        march(blocks.ctypes.data, len(blocks), ground.ctypes.data, STEPS, SUBSTEPS, STEP)
        return blocks[:, ROWS.index("peak")].ravel()

    return run
