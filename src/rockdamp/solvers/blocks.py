"""The layout of a batch in the kernel's blocks of lanes, and runs of these in threads."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from itertools import repeat
from threading import Event
from typing import Any

import numpy as np
from numba import config

from rockdamp.arrays import Array
from rockdamp.errors import InputError, Rule, check_number
from rockdamp.solvers import kernel

WHOLE: Rule = (lambda n: (n >= 1) & (n == np.floor(n)), "a whole number, at least 1")
MOST_VALUES = 2**28  # of one array: 2 GiB
# Steps of one call of the kernel, summed over its blocks: they take a fraction of a second, so that
# Ctrl-C is noticed.
STEPS_PER_CALL = 2**18


def available_threads() -> int:
    """Return the threads this process may use: NUMBA_NUM_THREADS where set, else its processors."""
    return int(config.NUMBA_NUM_THREADS)  # type: ignore[attr-defined]


class Blocks:
    """The layout of the lanes of a batch in blocks.

    Blocks are as narrow as their number allows, since an idle lane costs as much as a busy one.
    Copies of the last lane fill up the last block.

    Parameters
    ----------
    shape : tuple of int
        Shape of the batch.
    stored : int
        Number of values that are stored for each lane.

    Attributes
    ----------
    lanes, count, width : int
        Number of lanes in the batch, of blocks, and of lanes in each block.

    Raises
    ------
    InputError
        If the batch has more values than an array may hold.
    """

    def __init__(self, shape: tuple[int, ...], stored: int) -> None:
        self.shape = shape
        self.lanes = math.prod(shape)
        if self.lanes * max(stored, kernel.ROWS) > MOST_VALUES:
            raise InputError(
                f"{self.lanes} histories of {stored} values are more than {MOST_VALUES} values; "
                "run parts"
            )
        fewest_blocks = max(math.ceil(self.lanes / kernel.LANES), 1)
        self.width = max(math.ceil(self.lanes / fewest_blocks), 1)
        if self.width >= 4:  # a narrower block is computed lane by lane
            self.width = math.ceil(self.width / kernel.VECTOR) * kernel.VECTOR
        self.count = math.ceil(self.lanes / self.width)

    def arrange(self, rows: Sequence[Any] | Array, distance: int) -> Array:
        """Return rows of values in blocks, shape (blocks, rows, distance).

        Parameters
        ----------
        rows : sequence of floats and ndarrays
            Each row broadcasts to the shape of the batch.
        distance : int
            Distance between the rows of a block, at least the width.
        """
        places = np.arange(self.count * self.width)
        lanes = np.minimum(places, self.lanes - 1)
        blocks = aligned_zeros((self.count, len(rows), distance))
        for number, row in enumerate(rows):
            values = np.broadcast_to(row, self.shape).reshape(-1)[lanes]
            blocks[:, number, : self.width] = values.reshape(self.count, self.width)
        return blocks

    def batch(self, values: Array) -> Array:
        """Return values of the shape (blocks, width, ...) in the shape of the batch."""
        values_shape = values.shape[2:]
        lanes = values.reshape(-1, *values_shape)[: self.lanes]
        return lanes.reshape((*self.shape, *values_shape))

    def run_in_threads(
        self, advance: Callable[[slice, Event], None], steps: int, threads: int | None
    ) -> None:
        """Call a function on parts of the blocks, side by side; no result depends on the parts.

        Where one part fails, or the user interrupts the run, the others stop between two calls of
        the kernel.

        Parameters
        ----------
        advance : callable
            Takes a slice of the blocks, and an event that tells it to stop.
        steps : int
            Steps of the run.
        threads : int, optional
            Threads to use; by default as many as the process may use.
        """
        stopped = Event()
        # For fewer than 2^13 steps of a block, a thread costs more than it saves.
        workers = min(available_threads(), self.count * steps // 2**13)
        if threads is not None:
            workers = int(check_number("threads", threads, *WHOLE))
        workers = min(workers, self.count)
        if workers <= 1:
            advance(slice(0, self.count), stopped)
            return
        # Four parts a thread, as some take longer than others.
        parts = min(4 * workers, self.count)
        edges = np.linspace(0, self.count, parts + 1).astype(int).tolist()
        slices = map(slice, edges[:-1], edges[1:])
        with ThreadPoolExecutor(workers) as pool:
            try:
                list(pool.map(advance, slices, repeat(stopped)))
            finally:
                stopped.set()


def steps_per_call(part: slice, multiple_of: int = 1) -> int:
    """Return the steps that one call of the kernel may take with a part of the blocks.

    Parameters
    ----------
    part : slice
        Blocks that the call advances.
    multiple_of : int
        The result is a multiple of this number.
    """
    steps = STEPS_PER_CALL // max(part.stop - part.start, 1)
    return max(steps // multiple_of, 1) * multiple_of


def aligned_zeros(shape: tuple[int, ...]) -> Array:
    """Return zeros that begin at a line of the processor's cache, which holds 8 numbers.

    A vector that lay in two lines would cost up to 8 % of the time.
    """
    size = math.prod(shape)
    spare = np.zeros(size + 7)
    start = -(spare.ctypes.data // spare.itemsize) % 8
    return spare[start : start + size].reshape(shape)
