"""Batched stepper for walls that rock to one side, with the stop as a spring and a dashpot: thousands of lanes.

Explicit Newmark (beta 0, gamma 1/2). The dashpot acts at the end of the step. The tie returns to its yield surface at
the end of each step, and its set stays. Lanes of a block advance together, in loops without branches that the compiler
makes vectors of. Nothing here is the event-driven solver's, which checks it.

Dimensionless: x = u/u_ins, tau = p t, unit mass, forces over F0.
"""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from functools import cache
from typing import Any

import numpy as np
from numba.extending import register_jitable
from numpy.typing import ArrayLike

from rockdamp.arguments import whole
from rockdamp.arrays import Array
from rockdamp.errors import require
from rockdamp.mechanics.one_sided import RIGID, OneSidedForce, Stop
from rockdamp.solvers.compiled import compiled
from rockdamp.solvers.newmark import available_threads
from rockdamp.solvers.response import Histories, Response

LANES = 64  # of a block
# A block is one flat array, so that the compiler sees that its rows cannot overlap: row R of lane i is block[R + i].
# First what `OneSidedForce.parameters` says, then the stop, the step and the load, then the state.
ROWS = 26
SLOPE, INITIAL, B1, KS, A1, A2, A3, KT, FT, GAP, RUPTURE, KC, C, PULLS, H, FACTOR = (LANES * row for row in range(16))
X, V, A, SLACK, INTACT, ALIVE, PEAK, PEAK_AT, END, IMPACTS = (LANES * row for row in range(16, ROWS))
NEVER = 1e300  # stretch at which a tie breaks that does not: infinities are no numbers to the compiler
PATIENCE = 256  # steps after which a block is asked whether any of its walls survives so far
# No `contract`: where lanes are left over beside whole vectors, sums would be rounded otherwise than in those.
FASTMATH = {"nnan", "ninf", "nsz"}


# --- compiled ---------------------------------------------------------------------------------------------------------


@register_jitable
def advance(w, width, load, step):
    """Take a step of each lane of a block under the ground's acceleration at its end."""
    for i in range(width):
        h, alive, before = w[H + i], w[ALIVE + i] > 0.0, w[X + i]
        x = before + h * (w[V + i] + 0.5 * h * w[A + i])
        away, pressed = max(x, 0.0), min(x, 0.0)
        held = max(min(min(w[INITIAL + i] + w[SLOPE + i] * away, w[B1 + i]), w[KS + i] * (w[A3 + i] - away)), 0.0)
        tension = w[KT + i] * (x - w[SLACK + i])
        intact = w[INTACT + i] if x - w[GAP + i] <= w[RUPTURE + i] else 0.0
        beyond = max(tension - w[FT + i], 0.0) if w[KT + i] > 0.0 else 0.0
        slack = w[SLACK + i] + beyond / max(w[KT + i], 1e-300)
        tension = intact * max(min(tension, w[FT + i]), 0.0)
        net = w[FACTOR + i] * load - held - tension
        half = w[V + i] + 0.5 * h * w[A + i]
        spring = w[KC + i] * pressed
        a = (net - spring - w[C + i] * half) / (1.0 + 0.5 * h * w[C + i])
        stop = spring + w[C + i] * (half + 0.5 * h * a)
        a = a if (x < 0.0) & ((stop < 0.0) | (w[PULLS + i] > 0.0)) else net
        w[X + i] = x if alive else before
        w[V + i] = half + 0.5 * h * a if alive else w[V + i]
        w[A + i] = a if alive else w[A + i]
        w[SLACK + i] = slack if alive else w[SLACK + i]
        w[INTACT + i] = intact if alive else w[INTACT + i]
        w[IMPACTS + i] += 1.0 if alive & (before >= 0.0) & (x < 0.0) else 0.0
        w[PEAK_AT + i] = step if alive & (x > w[PEAK + i]) else w[PEAK_AT + i]
        w[PEAK + i] = x if alive & (x > w[PEAK + i]) else w[PEAK + i]
        w[END + i] = step if alive else w[END + i]
        w[ALIVE + i] = 1.0 if alive & (x <= w[A3 + i]) else 0.0


def march(blocks, width, ground, substeps, steps, every, displacement, velocity):
    """Advance blocks of lanes, shape (blocks, ROWS * LANES), from tau = 0.

    Each `every`-th step is stored where there is room. `ground` is linear between samples that are `substeps` steps
    apart, and zero after the last.
    """
    for b in range(blocks.shape[0]):
        w = blocks[b]
        for step in range(1, steps + 1):
            sample, part = divmod(step, substeps)
            load = ground[sample] if sample < ground.size else 0.0
            if part > 0 and sample < ground.size - 1:
                load += (ground[sample + 1] - load) * part / substeps
            elif part > 0:
                load = 0.0
            advance(w, width, load, step)
            if displacement.shape[0] > 0 and step % every == 0:
                for i in range(width):
                    if w[ALIVE + i] > 0.0:
                        displacement[b, step // every, i], velocity[b, step // every, i] = w[X + i], w[V + i]
            if step % PATIENCE == 0:
                standing = 0.0
                for i in range(width):
                    standing += w[ALIVE + i]
                if standing == 0.0:
                    break


# --- called from outside ----------------------------------------------------------------------------------------------


def solve(
    force: OneSidedForce,
    stop: Stop,
    *,
    step: ArrayLike,
    steps: int,
    load_factor: ArrayLike = 0.0,
    ground_acceleration: ArrayLike = (),
    substeps: int = 1,
    release_amplitude: ArrayLike = 0.0,
    release_velocity: ArrayLike = 0.0,
    store_every: int | None = None,
    threads: int | None = None,
) -> Response:
    """Integrate every lane of a batch; what has values by lane broadcasts together.

    Parameters
    ----------
    force, stop : OneSidedForce, Stop
        The stop must give way: a rigid one is the event-driven solver's.
    step : float or ndarray
        In tau, at most 1/sqrt(kc); 0.1/sqrt(kc) is usual. [-]
    steps : int
    load_factor : float or ndarray
        Makes the ground's acceleration the dimensionless load. [s2 m-1]
    ground_acceleration : ndarray, shape (samples,)
        Linear between its samples, which are `substeps` steps apart. [m s-2]
    release_amplitude, release_velocity : float or ndarray
        At the start. [-]
    store_every : int, optional
        Store the histories at every this many steps.

    Returns
    -------
    Response
        Its peaks are those away from the stop. `Histories` with `store_every`.

    Raises
    ------
    InputError
        If the stop is rigid, or the step too long for it.
    """
    steps, substeps = whole("steps", steps, 1), whole("substeps", substeps, 1)
    kc = np.asarray(stop.stiffness, dtype=float)
    require(np.isfinite(kc), "stiffness of the stop", kc, "finite: the stepper has no rigid stop")
    require(np.asarray(step) * np.sqrt(kc) <= 1, "step times sqrt(kc)", np.asarray(step) * np.sqrt(kc), "at most 1")
    ground = np.array(ground_acceleration, dtype=float)
    first = ground[0] if ground.size else 0.0
    damper = (kc, stop.coefficient, float(stop.pulls), step, load_factor, release_amplitude, release_velocity)
    *columns, x, v = (np.asarray(each, dtype=float) for each in np.broadcast_arrays(*force.parameters(), *damper))
    shape, count = x.shape, x.size
    number = -(-count // LANES)
    rows = {index * LANES: np.ravel(column) for index, column in enumerate(columns)}
    rows[RUPTURE] = np.where(rows[RUPTURE] == RIGID, NEVER, rows[RUPTURE])
    rows |= {X: np.ravel(x), V: np.ravel(v), INTACT: np.ones(count), ALIVE: np.ones(count)}
    elastic = np.divide(rows[FT], rows[KT], out=np.full(count, np.inf), where=rows[KT] > 0)
    rows |= {SLACK: np.maximum(rows[GAP], rows[X] - elastic), PEAK: np.maximum(rows[X], 0.0)}
    rows |= {A: _first_acceleration(rows, first)}
    blocks = np.zeros((number, ROWS, LANES))
    for row, values in rows.items():  # the last block is filled up, with lanes that count as collapsed
        blocks[:, row // LANES] = np.resize(values, number * LANES).reshape(number, LANES)
    blocks[-1, ALIVE // LANES, count - (number - 1) * LANES :] = 0.0
    kept = steps // store_every + 1 if store_every else 0
    displacement, velocity = np.full((2, number if store_every else 0, kept, LANES), np.nan)
    if store_every:
        displacement[:, 0], velocity[:, 0] = blocks[:, X // LANES], blocks[:, V // LANES]
    width = min(count, LANES) if number == 1 else LANES

    flat = blocks.reshape(number, ROWS * LANES)

    def through(part: slice) -> None:
        stored = displacement[part], velocity[part]
        _compiled()(flat[part], width, ground, substeps, steps, store_every or 1, *stored)

    with ThreadPoolExecutor(min(threads or available_threads(), number)) as pool:
        list(pool.map(through, [slice(b, b + 1) for b in range(number)]))

    def lanes(row: int) -> Array:
        return blocks[:, row // LANES].reshape(-1)[:count].reshape(shape)

    h = np.reshape(rows[H], shape)
    ends = (
        (lanes(ALIVE) == 0).astype(np.int8),
        lanes(END) * h,
        lanes(PEAK),
        lanes(PEAK_AT) * h,
        lanes(IMPACTS).astype(np.int64),
    )
    if not store_every:
        return Response(*ends)
    return Histories(*ends, *(_by_lane(values, shape) for values in (displacement, velocity)))


def _first_acceleration(rows: dict[int, Array], ground: float) -> Array:
    """Return the acceleration at the start; at the stop and at rest the stop bears what the load does not lift."""
    x, v = rows[X], rows[V]
    held = np.minimum(rows[INITIAL] + rows[SLOPE] * np.maximum(x, 0.0), rows[B1])
    held = np.maximum(np.minimum(held, rows[KS] * (rows[A3] - x)), 0.0)
    tension = np.clip(rows[KT] * (x - rows[SLACK]), 0.0, rows[FT])
    net = rows[FACTOR] * ground - held - tension
    return np.where((x == 0) & (v == 0), np.maximum(net, 0.0), net)


def _by_lane(values: Array, shape: tuple[int, ...]) -> Array:
    """Return histories by lane from histories by block."""
    count = int(np.prod(shape))
    return values.transpose(0, 2, 1).reshape(-1, values.shape[1])[:count].reshape(*shape, values.shape[1])


@cache
def _compiled() -> Any:
    return compiled(march, march, fastmath=FASTMATH)
