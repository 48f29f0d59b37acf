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
ROWS = (
    "x",
    "v",
    "a",
    "peak",
    "k1",
    "b1",
    "ks",
    "a1",
    "a2",
    "a3",
    "factor",
    "e",
    "c",
)  # of the struct Block


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
    """Return a function that runs the walls by C and returns their peaks; their number is a multiple of LANES."""
    model, curve, xi = walls.damping.model, walls.curve, walls.damping.value
    w1 = curve.initial_frequency
    parameters = walls.damping.kernel_arguments(curve)[1]
    size, reach = parameters[:2] if model == "BAND" else (0.0, xi)
    constant = {
        "CR": 0.0,
        "CDC": 2 * w1 * xi,
        "CDR": 2 * xi,
        "SDR": 2 * xi / w1,
        "ECD": 2 * xi,
        "BAND": size,
    }[model]
    columns = (
        0.0,
        0.0,
        walls.factor * walls.ground[0],
        0.0,
        *curve.parameters(),
        walls.factor,
        reach,
        constant,
    )
    flat = np.stack([np.broadcast_to(column, walls.factor.size) for column in columns])
    start = np.ascontiguousarray(flat.reshape(len(ROWS), -1, LANES).swapaxes(0, 1), dtype=float)
    blocks, ground = start.copy(), np.ascontiguousarray(walls.ground)
    march = getattr(library, f"march_{model}")
    march.argtypes = [
        ctypes.c_void_p,
        ctypes.c_long,
        ctypes.c_void_p,
        ctypes.c_long,
        ctypes.c_long,
        ctypes.c_double,
    ]

    def run() -> np.ndarray:
        np.copyto(blocks, start)
        march(blocks.ctypes.data, len(blocks), ground.ctypes.data, STEPS, SUBSTEPS, STEP)
        return blocks[:, ROWS.index("peak")].ravel()

    return run
