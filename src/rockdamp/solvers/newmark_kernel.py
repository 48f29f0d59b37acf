"""The batched solver's compiled code: the steps of both schemes, and the loop over steps and lanes.

A *lane* is one time history: one wall, one damper, one release. A history alone waits for each operation's result
before the next can begin; a processor's vector unit computes four or eight independent ones at once. So lanes advance
together in blocks of up to `LANES`, and every loop over the lanes of a block is free of branches and allocations: a
branch becomes a choice between two computed values, and the compiler vectorises the loop. A block is one flat array of
rows, a row for each variable, so that lanes which are computed together lie side by side in memory.

Each lane is computed by the same formulas whatever runs beside it, or by ones that give the same bits: its result does
not depend on its neighbours, on the number of lanes or on the number of threads.

Everything here is dimensionless: x = u/u_ins, tau = p t, unit mass, so f = F/(K0 u_ins). Symbols are the paper's:
a1, b1, a3 shape the curve, k1 = b1/a1 is the first branch's stiffness, ks the softening branch's (positive).

A lane alone keeps its state in the processor's registers, where a block would write and read each number at each step.

The loops are compiled once for each damper and scheme: `formula` and `stepped` only hold the places of the damper's
formula and of the scheme's step. So a step pays for what its damper needs, a damper that is added leaves the
machine code of the others as it is, and who uses one damper waits for no other.
"""

from functools import cache

import numpy as np
from numba.extending import register_jitable

from rockdamp.mechanics import trilinear
from rockdamp.mechanics.trilinear import TINY
from rockdamp.solvers.compiled import compiled, specialised

LANES = 64  # of a block at most, and the distance of its rows
VECTOR = 8  # lanes that are computed at once
# Of a block: up to three lanes are computed one after the other, more of them in vectors, which are filled up.
WIDTHS = (1, 2, 3, *range(VECTOR, LANES + 1, VECTOR))

# A block of lanes is one flat array, so that the compiler sees that its rows cannot overlap: row r of lane i is
# block[r + i]. First the state, then what is observed, then the parameters.
ROWS = 21
X, V, A, ALIVE, END, PEAK, PEAK_AT, CROSSINGS, ERROR = (LANES * row for row in range(9))
K1, B1, KS, A1, A2, A3, H, G, G_BEFORE = (LANES * row for row in range(9, 18))
P0, P1, P2 = (LANES * row for row in range(18, 21))  # the damper's, as `Damping.formula_parameters` gives them; CR's e
CURVE = (K1, B1, KS, A1, A2, A3)  # in the order of `TrilinearCurve.parameters`
DAMPER = (P0, P1, P2)

PATIENCE = 256  # steps after which a block is asked whether any of its walls survives so far
# Products may be fused with sums, and nothing may be ordered anew: a lane alone has the bits that it has in a block.
FASTMATH = {"nnan", "ninf", "nsz", "contract"}


# --- the steps of one lane: both schemes, for restitution and viscous damping -----------------------------------------
# A step takes the lane's state, its load at both ends, its curve (k1, b1, ks, a1, a2, a3) and its damper's parameters.
# It returns displacement, velocity and acceleration at its end.

force = register_jitable(trilinear.force)
tangent = register_jitable(trilinear.tangent)
double_energy = register_jitable(trilinear.double_energy)


@register_jitable
def newmark_end(v, a, h, p, restoring, c):
    """Explicit Newmark (beta 0, gamma 1/2): velocity and acceleration at the end of a step, its displacement known."""
    half = v + 0.5 * h * a
    a = (p - restoring - c * half) / (1.0 + 0.5 * h * c)
    return half + 0.5 * h * a, a


@register_jitable
def linear_acceleration(v, a, h, dp, k, c):
    """Return increments of displacement and velocity by linear acceleration, stiffness and damping frozen in a step."""
    dx = (dp + 6.0 * v / h + 3.0 * a + c * (3.0 * v + 0.5 * h * a)) / (k + 3.0 * c / h + 6.0 / (h * h))
    return dx, 3.0 * dx / h - 3.0 * v - 0.5 * h * a


@register_jitable(fastmath=False)
def product(one, other):
    """Round a product before it enters a sum, alike in a vector of lanes and in a lane alone."""
    return one * other


@register_jitable
def moved(x, v, a, h):
    """Return the displacement after a step, or a part of one, at a constant acceleration."""
    return x + product(h, v + 0.5 * h * a)


@register_jitable
def impact_within(x, v, a, h):
    """Return the time from the start of the step to the root of x + v s + a s^2/2, known to lie in (0, h]."""
    away = v if x > 0.0 else -v
    root = np.sqrt(np.maximum(v * v - 2.0 * a * x, 0.0))
    return np.minimum(2.0 * np.abs(x) / np.maximum(root - away, TINY), h)


@register_jitable
def crossed(before, after):
    """Tell if a step has reached or passed x = 0. By signs, as the product underflows late in a decay."""
    return ((before > 0.0) & (after <= 0.0)) | ((before < 0.0) & (after >= 0.0))


@register_jitable
def odd(x, f):
    """Return f with the sign of x: the force of f(|x|), and of a velocity how fast the wall moves away from x = 0."""
    return -f if x < 0.0 else f


@register_jitable
def force_at(z, curve):
    """Return the force at z = |x|."""
    k1, b1, ks, _, _, a3 = curve
    return force(z, k1, b1, ks, a3)


@register_jitable
def tangent_at(z, curve):
    """Return the slope of the force."""
    k1, _, ks, a1, a2, a3 = curve
    return tangent(z, k1, ks, a1, a2, a3)


def formula(z, f, double_v, v, parameters):
    """Hold the place of a damper's formula."""
    raise NotImplementedError


def damped_at(z, v, curve, parameters):
    """Return force and coefficient at z = |x| and v away from x = 0. What the formula does not use costs nothing."""
    z = np.maximum(z, TINY)  # the formula may divide by it, or by the energy there
    f = force_at(z, curve)
    return f, formula(z, f, double_energy(z, *curve), v, parameters)


def constantly_damped_at(z, v, curve, parameters):
    """Return the same of a damper whose coefficient is constant; the maximum would cost it a tenth of its time."""
    return force_at(z, curve), formula(0.0, 0.0, 0.0, 0.0, parameters)


def restitution_located(x, v, a, h, start, end, curve, damper):
    """CR, Eq. (8), the impact located inside the step: Newmark up to it, the velocity times e, Newmark after it."""
    hit = crossed(x, moved(x, v, a, h))
    s = impact_within(x, v, a, h) if hit else 0.0
    # At the impact x = 0, so the restoring force vanishes and the acceleration is the load's alone.
    load = start + (end - start) * (s / h)
    v = v + 0.5 * s * (a + load) if hit else v
    v = damped_at(0.0, v, curve, damper)[1] * v if hit else v
    a = load if hit else a
    return between_impacts(0.0 if hit else x, v, a, h - s, start, end, curve, damper)


@register_jitable
def between_impacts(x, v, a, h, start, end, curve, damper):
    """CR without an impact: Newmark without damping."""
    x = moved(x, v, a, h)
    v, a = newmark_end(v, a, h, end, odd(x, force_at(np.abs(x), curve)), 0.0)
    return x, v, a


def restitution_as_published(x, v, a, h, start, end, curve, damper):
    """CR as printed: linear acceleration without iteration, the velocity times e at the end of the step."""
    # ASSUME: the acceleration at the end of the step comes from the balance of forces there, not from the increment.
    dx, dv = linear_acceleration(v, a, h, end - start, tangent_at(np.abs(x), curve), 0.0)
    before, x, v = x, x + dx, v + dv
    v = damped_at(0.0, v, curve, damper)[1] * v if crossed(before, x) else v
    return x, v, end - odd(x, force_at(np.abs(x), curve))


def viscous_newmark(x, v, a, h, start, end, curve, damper):
    """Viscous damping by explicit Newmark.

    C is taken at the displacement at the end of the step and at the velocity v + h a that is expected there.
    """
    x = x + h * (v + 0.5 * h * a)
    f, c = damped_at(np.abs(x), odd(x, v + h * a), curve, damper)
    v, a = newmark_end(v, a, h, end, odd(x, f), c)
    return x, v, a


def viscous_as_published(x, v, a, h, start, end, curve, damper):
    """Viscous damping as printed: C and the tangent frozen at the step's start, balance restored at its end."""
    _, c = damped_at(np.abs(x), odd(x, v), curve, damper)
    dx, dv = linear_acceleration(v, a, h, end - start, tangent_at(np.abs(x), curve), c)
    x, v = x + dx, v + dv
    f, c = damped_at(np.abs(x), odd(x, v), curve, damper)
    return x, v, end - odd(x, f) - c * v


# --- one step of a block of lanes -----------------------------------------------------------------------------------


@register_jitable
def update_lane(w, i, x, v, a, step):
    """Take the new state unless the run has ended, and observe it: peak, crossings of x = 0, and collapse beyond a3."""
    alive = w[ALIVE + i] > 0.0
    old = w[X + i]
    z = np.abs(x) if alive else 0.0
    w[CROSSINGS + i] += 1.0 if alive & crossed(old, x) else 0.0
    w[PEAK_AT + i] = step if z > w[PEAK + i] else w[PEAK_AT + i]
    w[PEAK + i] = np.maximum(w[PEAK + i], z)
    w[END + i] = step if alive else w[END + i]
    w[ALIVE + i] = 1.0 if alive & (z <= w[A3 + i]) else 0.0
    w[X + i] = x if alive else old
    w[V + i] = v if alive else w[V + i]
    w[A + i] = a if alive else w[A + i]


@register_jitable
def described(w, i):
    """Return the step of lane i, its curve and its damper's parameters."""
    curve = w[K1 + i], w[B1 + i], w[KS + i], w[A1 + i], w[A2 + i], w[A3 + i]
    return w[H + i], curve, (w[P0 + i], w[P1 + i], w[P2 + i])


def stepped(x, v, a, h, start, end, curve, damper):
    """Hold the place of one of the steps above; it returns the displacement, velocity and acceleration at its end."""
    raise NotImplementedError


def advance(w, width, p0, p1, step):
    """Advance each lane by a step."""
    for i in range(width):
        h, curve, damper = described(w, i)
        start, end = product(w[G_BEFORE + i], p0), product(w[G + i], p1)
        x, v, a = stepped(w[X + i], w[V + i], w[A + i], h, start, end, curve, damper)
        update_lane(w, i, x, v, a, step)


def advance_by_impact(w, width, p0, p1, step):
    """Advance each lane by a step of CR. In few steps any lane has an impact; the others need no root or division."""
    impacts = 0
    for i in range(width):
        impacts += crossed(w[X + i], moved(w[X + i], w[V + i], w[A + i], w[H + i]))
    if impacts > 0:
        advance(w, width, p0, p1, step)
    else:
        advance_between(w, width, p0, p1, step)


def advance_between(w, width, p0, p1, step):
    """Hold the place of `advance` without impacts."""
    raise NotImplementedError


@register_jitable
def ground_at(ground, motion, step, substeps):
    """Return the acceleration of a motion at a step, linear between its samples."""
    sample, part = divmod(step, substeps)
    acceleration = ground[motion, sample]
    if part > 0:
        acceleration += (ground[motion, sample + 1] - acceleration) * part / substeps
    return acceleration


@register_jitable
def load_by_several(w, width, ground, factors, step, substeps):
    """Move each lane's load to the start of the step, and sum its motions at the end of it."""
    for i in range(width):
        w[G_BEFORE + i], w[G + i] = w[G + i], 0.0
    for motion in range(ground.shape[0]):
        acceleration = ground_at(ground, motion, step, substeps)
        for i in range(width):
            w[G + i] += factors[motion, i] * acceleration


@register_jitable
def compare_with(w, width, reference, row, step):
    """Add this step's term of Eq. (17)."""
    for i in range(width):
        difference = np.abs(reference[row[i], step]) - np.abs(w[X + i])
        w[ERROR + i] += difference * difference


@register_jitable
def keep(w, width, at, displacement, velocity):
    """Store the histories of the lanes that have not collapsed, as number `at`."""
    for i in range(width):
        if w[ALIVE + i] > 0.0:
            displacement[i, at], velocity[i, at] = w[X + i], w[V + i]


@register_jitable
def all_collapsed(w, width):
    """Say whether every lane has collapsed."""
    standing = 0.0
    for i in range(width):
        standing += w[ALIVE + i]
    return standing == 0.0


# --- the loop -------------------------------------------------------------------------------------------------------


def march_alone(w, ground, substeps, first, last, every, displacement, velocity):
    """Do what `march` does with one lane under one motion, in registers, and stop where it collapses."""
    forced, store = ground.size > 0, displacement.shape[0] > 0
    x, v, a, g, alive, step = w[X], w[V], w[A], w[G], w[ALIVE], int(w[END])
    peak, peak_at, crossings, a3 = w[PEAK], w[PEAK_AT], w[CROSSINGS], w[A3]
    h, curve, damper = described(w, 0)
    p1 = ground_at(ground, 0, first - 1, substeps) if forced else 0.0
    sample, part = (first - 1) // substeps, 0
    while alive > 0.0 and step < last:
        step += 1
        p0, before = p1, x
        if forced:  # as `ground_at`, but counted: to divide the steps takes longer
            part += 1
            if part == substeps:
                sample, part = sample + 1, 0
            p1 = ground[0, sample]
            if part > 0:
                p1 += (ground[0, sample + 1] - p1) * part / substeps
        x, v, a = stepped(x, v, a, h, product(g, p0), product(g, p1), curve, damper)
        z = np.abs(x)
        if crossed(before, x):
            crossings += 1.0
        if z > peak:
            peak, peak_at = z, float(step)
        if z > a3:
            alive = 0.0
        elif store and step % every == 0:
            displacement[0, 0, step // every], velocity[0, 0, step // every] = x, v
    w[X], w[V], w[A], w[ALIVE], w[END] = x, v, a, alive, float(step)
    w[PEAK], w[PEAK_AT], w[CROSSINGS] = peak, peak_at, crossings


def march(
    blocks,
    width,
    ground,
    factors,
    substeps,
    first,
    last,
    reference,
    row,
    checkpoints,
    error,
    every,
    displacement,
    velocity,
):
    """Advance blocks of lanes by the steps `first` to `last`, in place; the first of a run is step 1.

    Parameters
    ----------
    blocks, width : ndarray, shape (blocks, ROWS * LANES), and int
        State, observations and parameters, laid out as the constants above say; lanes of each block, of `WIDTHS`.
    ground : ndarray, shape (motions, samples)
        Shared accelerations, linear between samples; empty for a free decay. Of one motion, rows G and G_BEFORE
        hold each lane's factor on it.
    factors : ndarray, shape (blocks, motions, width)
        Of several motions, each lane's factors on them. Rows G and G_BEFORE then hold its loads at the end of the
        step and at its start.
    substeps, first, last : int
        Steps per sample of `ground`; and the steps to take, of which `first` follows on a sample.
    reference, row : ndarray, shape (cases, last + 1 or more) and (blocks, width)
        Displacements that Eq. (17) compares with, and each lane's case in it; no cases, no comparison.
    checkpoints, error : ndarray, shape (checkpoints,) and (blocks, checkpoints, width)
        Steps at which the running sum of Eq. (17) is stored, ascending, and the sums. A sum is only stored while a
        lane of the block survives; those of a collapsed lane mean nothing.
    every, displacement, velocity : int and ndarray, shape (blocks, width, last//every + 1 or more)
        Histories at each `every`-th step; no blocks, no histories. After a collapse they stay as they were made.
    """
    forced, motions = ground.size > 0, ground.shape[0]
    compare = reference.shape[0] > 0
    store = displacement.shape[0] > 0
    for b in range(blocks.shape[0]):
        w = blocks[b]
        mark = 0
        while mark < checkpoints.size - 1 and checkpoints[mark] < first:
            mark += 1
        p1 = ground_at(ground, 0, first - 1, substeps) if forced else 0.0
        if store and first == 1:
            keep(w, width, 0, displacement[b], velocity[b])
        if width == 1 and motions == 1 and not compare:
            march_alone(w, ground, substeps, first, last, every, displacement[b : b + 1], velocity[b : b + 1])
            continue
        for step in range(first, last + 1):
            p0 = p1
            if motions > 1:
                load_by_several(w, width, ground, factors[b], step, substeps)
                p0, p1 = 1.0, 1.0
            elif forced:
                p1 = ground_at(ground, 0, step, substeps)
            advance(w, width, p0, p1, step)
            if compare:
                compare_with(w, width, reference, row[b], step)
                if step == checkpoints[mark]:
                    for i in range(width):
                        error[b, mark, i] = w[ERROR + i]
                    mark = min(mark + 1, checkpoints.size - 1)
            if store and step % every == 0:
                keep(w, width, step // every, displacement[b], velocity[b])
            if step % PATIENCE == 0 and all_collapsed(w, width):
                break


STEPS = {  # by scheme and by `Damping.step_kind`
    "newmark": {"impact": restitution_located, "viscous": viscous_newmark},
    "paper": {"impact": restitution_as_published, "viscous": viscous_as_published},
}


@cache
def steps_of(scheme, formula, kind, is_constant, observe=update_lane):
    """Return a name, the step of one lane and that of a block of lanes, of one scheme and one damper's formula."""
    step = STEPS[scheme][kind]
    name = f"{step.__name__}_{formula.__qualname__}_{observe.__name__}"
    at = constantly_damped_at if is_constant else damped_at
    (force_and_coefficient,) = specialised((at,), name, formula=formula).values()
    (one_step,) = specialised((step,), name, damped_at=force_and_coefficient).values()
    (all_lanes,) = specialised((advance,), name, stepped=one_step, update_lane=observe).values()
    if step is restitution_located:
        (between,) = specialised((advance,), f"{name}_between", stepped=between_impacts, update_lane=observe).values()
        (all_lanes,) = specialised((advance_by_impact,), name, advance=all_lanes, advance_between=between).values()
    return name, one_step, all_lanes


@cache
def plain_march(scheme, formula, kind, is_constant):
    """Return the loop of one scheme and one damper's formula, as Python runs it."""
    name, one_step, all_lanes = steps_of(scheme, formula, kind, is_constant)
    return specialised((march_alone, march), name, stepped=one_step, advance=all_lanes)["march"]


@cache
def compiled_march(scheme, formula, kind, is_constant):
    """Return the same loop, which is compiled when it is first called."""
    return compiled(plain_march(scheme, formula, kind, is_constant), formula, fastmath=FASTMATH)
