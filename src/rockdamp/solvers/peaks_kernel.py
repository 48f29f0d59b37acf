"""The batched solver's loop where peaks and outcomes alone are asked for: `newmark_kernel` without what else it keeps.

The steps are the same, and so is each lane's peak, to the bit. But a lane that ends is not frozen at every step: every
`INTERVAL` steps those lanes leave whose answer is known, and the others move together, so that no block computes walls
that have collapsed or that only come to rest. A lane leaves

- that was beyond a3: it has collapsed;
- that cannot exceed its peak any more. Dampers and impacts only take energy, and a load p changes the velocity that the
  energy stands for by no more than its impulse: sqrt(v^2 + 2V(x)) grows by at most the integral of |p|. If that sum, by
  `MARGIN` larger, is less than sqrt(2V(peak)), the rest of the run is not needed. It is asked of steps up to
  `FINE`/w1, for which the scheme keeps energy far better than that.
"""

from functools import cache

import numpy as np
from numba.extending import register_jitable

from rockdamp.solvers import newmark_kernel as full
from rockdamp.solvers.compiled import compiled, specialised
from rockdamp.solvers.newmark_kernel import (
    A1,
    A2,
    A3,
    B1,
    ERROR,
    K1,
    KS,
    LANES,
    PEAK,
    ROWS,
    A,
    G,
    H,
    V,
    X,
    compare_with,
    double_energy,
    ground_at,
    load_by_several,
)

LANE = full.CROSSINGS  # the row that holds the lane's number here
INTERVAL = 128  # steps between two looks at who leaves
MARGIN = 1.01
FINE = 0.1  # of w1 h, a twentieth of the stability limit: at longer steps the corners of the curve feed energy in
NARROW = 8  # lanes of which blocks are made, unless they are fewer
COMPLETED, COLLAPSED, MOVES = 0, 1, -1


@register_jitable
def keep_peak(w, i, x, v, a, step):
    """Take the new state and keep the peak, in place of `newmark_kernel.update_lane`."""
    w[X + i], w[V + i], w[A + i] = x, v, a
    # The peak's own size: a value just read would be stored only where it changes, by masks, which take several times
    # as long on some processors.
    w[PEAK + i] = np.maximum(np.abs(w[PEAK + i]), np.abs(x))


@register_jitable
def double_energy_of(w, i, z):
    """Return 2V of a lane at z = |x|."""
    return double_energy(z, w[K1 + i], w[B1 + i], w[KS + i], w[A1 + i], w[A2 + i], w[A3 + i])


@register_jitable
def outcome_of(w, i, impulse):
    """Return how a lane ends, as far as that is known; `impulse` is the integral of |p| from now to the end."""
    if w[PEAK + i] > w[A3 + i]:
        return COLLAPSED
    if w[H + i] * w[H + i] * w[K1 + i] > FINE * FINE:
        return MOVES
    most = double_energy_of(w, i, w[PEAK + i])
    if MARGIN * impulse * (MARGIN * impulse) >= most:  # early in a record this answers for most
        return MOVES
    speed = np.sqrt(w[V + i] * w[V + i] + double_energy_of(w, i, np.abs(w[X + i]))) + impulse
    return COMPLETED if MARGIN * speed < np.sqrt(most) else MOVES


@register_jitable
def impulse_of(w, i, factors, remaining, substeps):
    """Return the integral of a lane's |p| over what remains of its motions, which is given in samples."""
    motions = remaining.size
    total = 0.0
    for motion in range(motions):
        total += np.abs(w[G + i] if motions == 1 else factors[motion, i]) * remaining[motion]
    return total * w[H + i] * substeps


@register_jitable
def move(blocks, factors, row, source, target):
    """Move a lane from one place to another."""
    (b, i), (to_b, to_i) = source, target
    for at in range(0, ROWS * LANES, LANES):
        blocks[to_b, at + to_i] = blocks[b, at + i]
    for motion in range(factors.shape[1]):
        factors[to_b, motion, to_i] = factors[b, motion, i]
    if row.shape[0] > 0:
        row[to_b, to_i] = row[b, i]


@register_jitable
def leave(blocks, width, moving, factors, row, remaining, substeps, ended, outcome, peak):
    """Note lanes that end, which all do where `ended`, and move the others together; return how many these are."""
    kept = 0
    b, i, to_b, to_i = 0, -1, 0, 0
    for lane in range(moving):
        i += 1
        if i == width:
            b, i = b + 1, 0
        w = blocks[b]
        found = COLLAPSED if w[PEAK + i] > w[A3 + i] else COMPLETED if ended else MOVES
        if found == MOVES and row.shape[0] == 0:  # Eq. (17) is a sum up to the end
            found = outcome_of(w, i, impulse_of(w, i, factors[b], remaining, substeps))
        if found == MOVES:
            if kept < lane:
                move(blocks, factors, row, (b, i), (to_b, to_i))
            kept, to_i = kept + 1, to_i + 1
            if to_i == width:
                to_b, to_i = to_b + 1, 0
        else:
            number = int(w[LANE + i])
            outcome[number] = found
            peak[number] = np.minimum(w[PEAK + i], w[A3 + i])
    return kept


@register_jitable
def loads_between(ground, substeps, first, last, loads):
    """Write the motions at the steps `first` - 1 to `last`, shape (motions, steps)."""
    for motion in range(ground.shape[0]):
        for step in range(first - 1, last + 1):
            loads[motion, step - first + 1] = ground_at(ground, motion, step, substeps) if ground.size > 0 else 0.0


def march_of_peaks(
    blocks,
    width,
    moving,
    ground,
    remaining,
    factors,
    substeps,
    first,
    last,
    steps,
    reference,
    row,
    checkpoints,
    error,
    outcome,
    peak,
):
    """Advance the first `moving` lanes of some blocks by the steps `first` to `last`; return how many move on.

    Parameters
    ----------
    blocks, width, ground, factors, substeps, first, last, reference, row, checkpoints
        As for `newmark_kernel.march`. Row LANE holds the lane's number. Lanes change their places in blocks, factors
        and row.
    moving, steps : int
        Lanes that move, and the steps of the whole run.
    remaining : ndarray, shape (motions, samples)
        The integral of each motion's absolute value from a sample to the end, with samples as the unit of time.
    error : ndarray, shape (checkpoints, lanes)
        Sums of Eq. (17), by the lane's number.
    outcome, peak : ndarray, shape (lanes,)
        Written for lanes that leave; the peak of a lane that collapsed is a3.
    """
    motions, compare = ground.shape[0], reference.shape[0] > 0
    mark = 0
    while mark < checkpoints.size - 1 and checkpoints[mark] < first:
        mark += 1
    while first <= last and moving > 0:
        stop = min(first + INTERVAL - 1, last)
        if compare and checkpoints[mark] >= first:
            stop = min(stop, checkpoints[mark])
        loads = np.zeros((motions, stop - first + 2))
        loads_between(ground, substeps, first, stop, loads)
        for b in range((moving + width - 1) // width):
            w, lanes = blocks[b], min(width, moving - b * width)
            lanes = lanes if width < NARROW else (lanes + NARROW - 1) // NARROW * NARROW
            for step in range(first, stop + 1):
                p0, p1 = loads[0, step - first], loads[0, step - first + 1]
                if motions > 1:
                    load_by_several(w, lanes, ground, factors[b], step, substeps)
                    p0, p1 = 1.0, 1.0
                advance(w, lanes, p0, p1, step)
                if compare:
                    compare_with(w, lanes, reference, row[b], step)
            if compare and stop == checkpoints[mark]:
                for i in range(min(width, moving - b * width)):
                    error[mark, int(w[LANE + i])] = w[ERROR + i]
        if compare and stop == checkpoints[mark]:
            mark = min(mark + 1, checkpoints.size - 1)
        left = remaining[:, min(stop // substeps, remaining.shape[1] - 1)]
        moving = leave(blocks, width, moving, factors, row, left, substeps, stop == steps, outcome, peak)
        first = stop + 1
    return moving


def advance(w, width, p0, p1, step):
    """Hold the place of `newmark_kernel.advance`."""
    raise NotImplementedError


@cache
def plain_march(scheme, formula, kind, is_constant):
    """Return the loop of one scheme and one damper's formula, as Python runs it."""
    name, _, all_lanes = full.steps_of(scheme, formula, kind, is_constant, keep_peak)
    return specialised((march_of_peaks,), name, advance=all_lanes)["march_of_peaks"]


@cache
def compiled_march(scheme, formula, kind, is_constant):
    """Return the same loop, which is compiled when it is first called."""
    return compiled(plain_march(scheme, formula, kind, is_constant), formula, fastmath=full.FASTMATH)
