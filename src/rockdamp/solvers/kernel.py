"""The compiled code of the batched solver: steps of one lane, two marches, and an entry for each.

A *lane* is one time history: one wall, one damper, one release. In a history alone, each operation
waits for the result of the one before, although the vector unit of a processor could compute
several at once. Lanes therefore advance together in blocks of up to `LANES`, and a loop over the
lanes of a block chooses between computed values in place of branches. A block is one flat array of
rows, a row for each variable: variable R of lane i is block[R + i]. The result of a lane depends
neither on the lanes beside it nor on the number of lanes or threads.

Templates build the code: `viscous_step(coefficient)` and `impact_step(restitution)` return the step
of a lane, `block_step` the loop over a block, `full_march` and `peaks_march` the loop over the
steps. The last lines compile an entry for each march, scheme and damper: `FULL` and `PEAKS`. Numba
keeps the machine code and recompiles when *this file* changes, but notices no other file. So the
compiled code uses neither functions nor numbers of other modules.

Everything is dimensionless: x = u/u_ins, tau = p t, unit mass, f = F/(K0 u_ins). The symbols are
the paper's: a1, b1 and a3 shape the curve, k1 = b1/a1 is the stiffness of the first branch, and
-ks < 0 that of the softening branch.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from numba.extending import register_jitable

from rockdamp.solvers.machine_code import compile_cached

LANES = 64  # most lanes of a block, and the distance between its rows
VECTOR = 8  # lanes computed at once; the width of a block of four or more lanes is a multiple of it
ROWS = 21
X, V, A, ALIVE, END, PEAK, PEAK_STEP, CROSSINGS, ERROR = range(0, 9 * LANES, LANES)
K1, B1, KS, A1, A2, A3 = range(9 * LANES, 15 * LANES, LANES)  # as `TrilinearCurve.parameters`
# Step; for one motion the load factor, twice; for several the loads at the step's end and start
H, G, G_START = range(15 * LANES, 18 * LANES, LANES)
P0, P1, P2 = range(18 * LANES, ROWS * LANES, LANES)  # parameters of the damper
LANE = CROSSINGS  # number of the lane, in the march of peaks

TINY = 1e-100  # avoids 0/0 at x = 0; its square and the inverse of that are still normal numbers
INTERVAL = 128  # steps after which finished lanes leave the march of peaks
COMPLETED, COLLAPSED, RUNNING = 0, 1, -1

COEFFICIENTS: dict[str, Callable[..., Any]] = {}  # formulas of C, by name
RESTITUTIONS: dict[str, Callable[..., Any]] = {}  # laws of the restitution, by name


def compile_entry(name, function):
    """Compile a function under a unique name, by which Numba finds its machine code again."""
    function.__name__ = function.__qualname__ = name
    # Fused multiply-adds are allowed and reassociation is not, lest a result depend on the batch.
    fastmath = {"nnan", "ninf", "nsz", "contract"}
    return compile_cached(function, error_model="numpy", nogil=True, fastmath=fastmath)


def inline(function, *parts):
    """Make a function from a template available to compiled code, under a unique name.

    Numba tells machine code apart by names: of two functions of one name, the one that was read
    from the cache would be taken for the other.
    """
    function.__qualname__ = "_".join([function.__name__, *(part.__qualname__ for part in parts)])
    return register_jitable(function)


def damping_formula(function):
    """Register a formula of C under its name."""
    COEFFICIENTS[function.__name__] = function
    return register_jitable(function)


def restitution_law(function):
    """Register a law of the restitution under its name."""
    RESTITUTIONS[function.__name__] = function
    return register_jitable(function)


# --- the curve ------------------------------------------------------------------------------------


@register_jitable
def force(z, curve):
    """Return the restoring force at z = |x|: the lowest of the three lines, zero beyond a3."""
    k1, b1, ks, _, _, a3 = curve
    return np.maximum(np.minimum(np.minimum(k1 * z, b1), ks * (a3 - z)), 0.0)


@register_jitable
def tangent(z, curve):
    """Return the slope of the force; at a corner the slope of the outer branch."""
    k1, _, ks, a1, a2, a3 = curve
    return k1 * (z < a1) - ks * ((z >= a2) & (z < a3))


@register_jitable
def double_energy(z, curve):
    """Return twice the stored energy 2V(z), V the integral of the force."""
    k1, b1, ks, a1, a2, a3 = curve
    z1 = np.minimum(z, a1)
    z2 = np.minimum(np.maximum(z, a1), a2)
    z3 = np.minimum(np.maximum(z, a2), a3)
    return k1 * z1 * z1 + 2.0 * b1 * (z2 - a1) + ks * (z3 - a2) * (2.0 * a3 - a2 - z3)


# --- the dampers ----------------------------------------------------------------------------------
# A formula of C takes z = |x|, f(z), 2V(z), the outward velocity v (positive away from x = 0), the
# step h, and p, the three parameters of `Damping.kernel_arguments`. An argument that it does not
# use costs nothing.


@damping_formula
def cdc(z, f, double_v, v, h, p):
    """Return C = 2 xi w1, Eq. (10); p[0] is C."""
    return p[0]


@damping_formula
def cdr(z, f, double_v, v, h, p):
    """Return C = 2 xi w with the secant frequency w = sqrt(f/z), Eq. (11); p[0] is 2 xi."""
    return p[0] * np.sqrt(f / z)


@damping_formula
def sdr(z, f, double_v, v, h, p):
    """Return C = 2 xi w^2/w1 with w^2 = f/z, Eq. (12); p[0] is 2 xi/w1."""
    return p[0] * (f / z)


@damping_formula
def ecd(z, f, double_v, v, h, p):
    """Return C = kappa f/sqrt(2V) of ECD of order 0; p[0] is kappa."""
    return p[0] * np.sqrt(f * f / double_v)


@register_jitable
def phase_coefficient(size, f, double_v, v, inverse, has_phase):
    """Return C = size w_E/(1 - size cos(phi) sin(phi)) of ECD, w_E = f/sqrt(2V).

    The phase has tan(phi) = sqrt(V/T), and `size` is kappa cos(phi)^2m. `inverse` is 1/(2T + 2V).
    """
    root = np.sqrt(double_v)
    # The largest subtrahend is `half_cycle_loss.CAP`, with which half cycles still end.
    return size * f / (root * (1.0 - np.minimum(size * v * root * inverse, 0.95) * has_phase))


@damping_formula
def ecd_doubled(z, f, double_v, v, h, p):
    """Return C of ECD of order 1, 2, 4, ... 128; p has kappa and the order.

    The power cos(phi)^2m is computed by squares, which the compiler makes vectors of.
    """
    m = p[1]
    inverse = 1.0 / (v * v + double_v)
    power = v * v * inverse
    power = power * power if m >= 2.0 else power
    power = power * power if m >= 4.0 else power
    power = power * power if m >= 8.0 else power
    power = power * power if m >= 16.0 else power
    power = power * power if m >= 32.0 else power
    power = power * power if m >= 64.0 else power
    power = power * power if m >= 128.0 else power
    return phase_coefficient(p[0] * power, f, double_v, v, inverse, 1.0)


@damping_formula
def ecd_any(z, f, double_v, v, h, p):
    """Return C of ECD of any order m and loss exponent g; p has kappa (2E_r)^g, m and g.

    The size kappa (E_r/E)^g cos(phi)^2m falls with the energy E. Without m and g there is no phase.
    """
    _, m, g = p
    inverse = 1.0 / (v * v + double_v)
    size = p[0] * inverse**g * (v * v * inverse) ** m
    return phase_coefficient(size, f, double_v, v, inverse, m + g > 0.0)


@damping_formula
def band(z, f, double_v, v, h, p):
    """Return C = size (1 - (z/(c v))^2) of BAND, 0 outside the band; p has size and c = t_c/w1.

    At rest C is the size at z = 0 and 0 elsewhere.
    """
    r = np.minimum(z / np.maximum(p[1] * np.abs(v), 1e-90), 1.0)
    return p[0] * (1.0 - r * r)


@damping_formula
def cqd(z, f, double_v, v, h, p):
    """Return C = mu(z) |v| of CQD, mu(z) = size (1 - (z/w)^2)/w; p has size and w.

    It is the mean over the way from z - h v/2 to z + h v/2, lest a step jump over the band.
    """
    half = 0.5 * h * v
    a = np.minimum(np.maximum((z - half) / p[1], -1.0), 1.0)
    b = np.minimum(np.maximum((z + half) / p[1], -1.0), 1.0)
    # The integral of 1 - s^2 from a to b, with s = z/w.
    return p[0] * np.abs((b - a) * (1.0 - (a * a + a * b + b * b) / 3.0)) / h


@restitution_law
def cr(v, p):
    """Return the factor e on the velocity at an impact, Eq. (8); p[0] is e."""
    return p[0]


@restitution_law
def cr_law(v, p):
    """Return the factor on the speed v where E+^g = E-^g - E_r^g (1 - e^2g), 0 where none is left.

    p has e, g and 2E_r. The quotient of the energies keeps it well conditioned down to g = 0.
    """
    e, g, double_reference = p
    # The bounds keep quotients and logarithms finite in each lane, also where g = 0 or v = 0.
    # (E_r/E-)^g; exp(700) is far beyond a stop and does not overflow.
    log_ratio = np.minimum(g * np.log(double_reference / np.maximum(v * v, 1e-200)), 700.0)
    change = np.exp(log_ratio) * np.expm1(2.0 * g * np.log(e))  # (E+/E-)^g - 1
    factor = np.exp(np.log1p(np.maximum(change, -1.0 + 1e-16)) / np.maximum(2.0 * g, 1e-300))
    factor = factor if change > -1.0 else 0.0
    return e if g == 0.0 else factor


# --- one step of one lane -------------------------------------------------------------------------
# A step takes the state of the lane, the step h, the loads at its start and end, the curve and the
# parameters of the damper. It returns displacement, velocity and acceleration at its end.


@register_jitable
def signed(x, f):
    """Return f with the sign of x: the force from f(|x|), or the outward velocity from v."""
    return -f if x < 0.0 else f


@register_jitable(fastmath=False)
def rounded_product(a, b):
    """Round a product before it enters a sum, alike in a vector of lanes and in a lane alone."""
    return a * b


@register_jitable
def predict(x, v, a, h):
    """Return the displacement after a step at a constant acceleration."""
    return x + rounded_product(h, v + 0.5 * h * a)


@register_jitable
def crosses_zero(x, x_end):
    """Tell if a step from x reaches or passes 0. By signs, as the product underflows in a decay."""
    return ((x > 0.0) & (x_end <= 0.0)) | ((x < 0.0) & (x_end >= 0.0))


@register_jitable
def time_to_impact(x, v, a, h):
    """Return the root of x + v s + a s^2/2, known to lie in (0, h]: the time s to the impact."""
    outward_v = v if x > 0.0 else -v
    root = np.sqrt(np.maximum(v * v - 2.0 * a * x, 0.0))
    return np.minimum(2.0 * np.abs(x) / np.maximum(root - outward_v, TINY), h)


@register_jitable
def newmark_end(v, a, h, load, restoring, c):
    """Return velocity and acceleration at the end of an explicit Newmark step (beta 0, gamma 1/2).

    Load, restoring force and coefficient are those at its end, where the displacement is known.
    """
    half_v = v + 0.5 * h * a
    a = (load - restoring - c * half_v) / (1.0 + 0.5 * h * c)
    return half_v + 0.5 * h * a, a


def viscous_step(coefficient):
    """Explicit Newmark; C at the displacement at the step's end and the velocity v + h a there."""

    def step_viscous(x, v, a, h, start, end, curve, damper):
        x = x + h * (v + 0.5 * h * a)
        z = np.maximum(np.abs(x), TINY)
        f = force(z, curve)
        c = coefficient(z, f, double_energy(z, curve), signed(x, v + h * a), h, damper)
        v, a = newmark_end(v, a, h, end, signed(x, f), c)
        return x, v, a

    return inline(step_viscous, coefficient)


@register_jitable
def constant_step(x, v, a, h, start, end, curve, damper):
    """Step as `viscous_step` with a constant C; without z > 0, which would cost a tenth more."""
    x = x + h * (v + 0.5 * h * a)
    v, a = newmark_end(v, a, h, end, signed(x, force(np.abs(x), curve)), damper[0])
    return x, v, a


@register_jitable
def free_step(x, v, a, h, start, end, curve, damper):
    """Step without damping and without an impact."""
    x = predict(x, v, a, h)
    v, a = newmark_end(v, a, h, end, signed(x, force(np.abs(x), curve)), 0.0)
    return x, v, a


def impact_step(restitution):
    """CR, Eq. (8), the impact located in the step: Newmark to it, the velocity times e, Newmark."""

    def step_with_impact(x, v, a, h, start, end, curve, damper):
        has_impact = crosses_zero(x, predict(x, v, a, h))
        s = time_to_impact(x, v, a, h) if has_impact else 0.0
        load = start + (end - start) * (s / h)  # at x = 0 the restoring force vanishes
        v = v + 0.5 * s * (a + load) if has_impact else v
        v = restitution(v, damper) * v if has_impact else v
        a = load if has_impact else a
        x = 0.0 if has_impact else x
        return free_step(x, v, a, h - s, start, end, curve, damper)

    return inline(step_with_impact, restitution)


@register_jitable
def linear_acceleration(v, a, h, load_change, k, c):
    """Return increments of x and v by linear acceleration, stiffness k and C frozen in the step.

    This is Newmark's method (1959, J. Eng. Mech. Div. ASCE 85(EM3)) with beta = 1/6, gamma = 1/2.
    """
    force_change = load_change + 6.0 * v / h + 3.0 * a + c * (3.0 * v + 0.5 * h * a)
    dx = force_change / (k + 3.0 * c / h + 6.0 / (h * h))
    dv = 3.0 * dx / h - 3.0 * v - 0.5 * h * a
    return dx, dv


# ASSUME: in the paper's scheme the acceleration at the end of a step comes from the balance of
# forces there, not from the increment.


def paper_step(coefficient):
    """The printed scheme: linear acceleration without iteration, C and tangent of the start."""

    def step_as_printed(x, v, a, h, start, end, curve, damper):
        k = tangent(np.abs(x), curve)
        z = np.maximum(np.abs(x), TINY)
        f = force(z, curve)
        c = coefficient(z, f, double_energy(z, curve), signed(x, v), h, damper)
        dx, dv = linear_acceleration(v, a, h, end - start, k, c)
        x = x + dx
        v = v + dv
        z = np.maximum(np.abs(x), TINY)
        f = force(z, curve)
        c = coefficient(z, f, double_energy(z, curve), signed(x, v), h, damper)
        return x, v, end - signed(x, f) - c * v

    return inline(step_as_printed, coefficient)


def paper_impact_step(restitution):
    """The printed scheme for CR: after a crossing, the velocity at the end of the step times e."""

    def step_with_impact_as_printed(x, v, a, h, start, end, curve, damper):
        dx, dv = linear_acceleration(v, a, h, end - start, tangent(np.abs(x), curve), 0.0)
        x_end = x + dx
        v = v + dv
        if crosses_zero(x, x_end):
            v = restitution(v, damper) * v
        return x_end, v, end - signed(x_end, force(np.abs(x_end), curve))

    return inline(step_with_impact_as_printed, restitution)


# --- one step of a block --------------------------------------------------------------------------


@register_jitable
def update_all(w, i, x, v, a, step):
    """Take the new state unless the wall has collapsed; update peak, crossings and collapse."""
    alive = w[ALIVE + i] > 0.0
    old_x = w[X + i]
    z = np.abs(x) if alive else 0.0
    w[CROSSINGS + i] += 1.0 if alive & crosses_zero(old_x, x) else 0.0
    w[PEAK_STEP + i] = step if z > w[PEAK + i] else w[PEAK_STEP + i]
    w[PEAK + i] = np.maximum(w[PEAK + i], z)
    w[END + i] = step if alive else w[END + i]
    w[ALIVE + i] = 1.0 if alive & (z <= w[A3 + i]) else 0.0
    w[X + i] = x if alive else old_x
    w[V + i] = v if alive else w[V + i]
    w[A + i] = a if alive else w[A + i]


@register_jitable
def update_peak(w, i, x, v, a, step):
    """Take the new state and update the peak."""
    w[X + i] = x
    w[V + i] = v
    w[A + i] = a
    # Through `abs` the peak is always stored. A value just read would be stored by a mask, only
    # where it changes, which takes several times as long on some processors.
    w[PEAK + i] = np.maximum(np.abs(w[PEAK + i]), np.abs(x))


def block_step(lane_step, update):
    """Return a function that advances each lane of a block while the motion goes from p0 to p1."""

    def advance(w, width, p0, p1, step):
        for i in range(width):
            curve = w[K1 + i], w[B1 + i], w[KS + i], w[A1 + i], w[A2 + i], w[A3 + i]
            damper = w[P0 + i], w[P1 + i], w[P2 + i]
            start = rounded_product(w[G_START + i], p0)
            end = rounded_product(w[G + i], p1)
            x, v, a = lane_step(w[X + i], w[V + i], w[A + i], w[H + i], start, end, curve, damper)
            update(w, i, x, v, a, step)

    return inline(advance, lane_step, update)


def block_step_with_impacts(restitution, update):
    """Return the same for CR.

    Most steps have no impact in any lane. They need neither its root nor its division.
    """
    advance_with_impacts = block_step(impact_step(restitution), update)
    advance_freely = block_step(free_step, update)

    def advance_by_impacts(w, width, p0, p1, step):
        impacts = 0
        for i in range(width):
            x_end = predict(w[X + i], w[V + i], w[A + i], w[H + i])
            impacts += crosses_zero(w[X + i], x_end)
        if impacts > 0:
            advance_with_impacts(w, width, p0, p1, step)
        else:
            advance_freely(w, width, p0, p1, step)

    return inline(advance_by_impacts, restitution, update)


@register_jitable
def motion_at(ground, motion, step, substeps):
    """Return the acceleration of a motion at a step, linear between its samples."""
    sample, part = divmod(step, substeps)
    acceleration = ground[motion, sample]
    if part > 0:
        acceleration += (ground[motion, sample + 1] - acceleration) * part / substeps
    return acceleration


@register_jitable
def add_motions(w, width, ground, factors, step, substeps):
    """Move the load of each lane to the start of the step, and sum its motions at the end."""
    for i in range(width):
        w[G_START + i] = w[G + i]
        w[G + i] = 0.0
    for motion in range(ground.shape[0]):
        acceleration = motion_at(ground, motion, step, substeps)
        for i in range(width):
            w[G + i] += factors[motion, i] * acceleration


# --- the march with histories ---------------------------------------------------------------------


@register_jitable
def store_states(w, width, index, displacement, velocity):
    """Store the states of the lanes that have not collapsed, under an index."""
    for i in range(width):
        if w[ALIVE + i] > 0.0:
            displacement[i, index] = w[X + i]
            velocity[i, index] = w[V + i]


@register_jitable
def any_alive(w, width):
    """Tell if any lane of a block has not collapsed."""
    count = 0.0
    for i in range(width):
        count += w[ALIVE + i]
    return count > 0.0


def full_march(advance):
    """Return a function that advances blocks by the steps `first` to `last`, in place.

    The first step of a run is step 1. The parameters of the function are:

    blocks, width : ndarray, shape (blocks, ROWS * LANES), and int
        The rows above, and the lanes of each block.
    ground : ndarray, shape (motions, samples)
        Accelerations shared by all lanes, linear between samples; empty for a free decay. For one
        motion the rows G and G_START hold the factor of each lane on it; for several, its loads at
        the end of the step and at its start.
    factors : ndarray, shape (blocks, motions, width)
        Factors of each lane on several motions.
    substeps, first, last : int
        Steps per sample of `ground`, and the steps to take.
    stride, displacement, velocity : int, and ndarray, shape (blocks, width, last//stride + 1)
        Histories at each `stride`-th step. After a collapse they keep their initial values.
    """

    def march(
        blocks, width, ground, factors, substeps, first, last, stride, displacement, velocity
    ):
        motions = ground.shape[0]
        has_load = ground.size > 0
        for b in range(blocks.shape[0]):
            w = blocks[b]
            p1 = motion_at(ground, 0, first - 1, substeps) if has_load else 0.0
            if first == 1:
                store_states(w, width, 0, displacement[b], velocity[b])
            for step in range(first, last + 1):
                p0 = p1
                if motions > 1:
                    add_motions(w, width, ground, factors[b], step, substeps)
                    p0 = 1.0
                    p1 = 1.0
                elif has_load:
                    p1 = motion_at(ground, 0, step, substeps)
                advance(w, width, p0, p1, step)
                if step % stride == 0:
                    store_states(w, width, step // stride, displacement[b], velocity[b])
                # Rarely enough to cost nothing.
                if step % 256 == 0 and not any_alive(w, width):
                    break

    return inline(march, advance)


# --- the march of peaks ---------------------------------------------------------------------------


@register_jitable
def lane_status(w, i, impulse):
    """Return COLLAPSED, COMPLETED (the lane cannot exceed its peak any more) or RUNNING.

    Dampers and impacts only take energy, and a load p raises sqrt(v^2 + 2V(x)) by at most its
    impulse, the integral of |p| from now to the end. If the sum of both, larger by a hundredth for
    the errors of the scheme, is less than sqrt(2V(peak)), the rest is not needed. No lane leaves
    early if w1 h > 0.1: at such steps the corners of the curve add more energy than the hundredth.
    """
    if w[PEAK + i] > w[A3 + i]:
        return COLLAPSED
    if w[H + i] * w[H + i] * w[K1 + i] > 0.1 * 0.1:
        return RUNNING
    curve = w[K1 + i], w[B1 + i], w[KS + i], w[A1 + i], w[A2 + i], w[A3 + i]
    largest = double_energy(w[PEAK + i], curve)
    # The impulse alone decides for most lanes early in a record.
    if 1.01 * impulse * (1.01 * impulse) >= largest:
        return RUNNING
    energy = w[V + i] * w[V + i] + double_energy(np.abs(w[X + i]), curve)
    speed = np.sqrt(energy) + impulse
    return COMPLETED if 1.01 * speed < np.sqrt(largest) else RUNNING


@register_jitable
def remaining_impulse(w, i, factors, remaining, substeps):
    """Return the integral of |p| of a lane over the rest of its motions, given in samples."""
    motions = remaining.size
    total = 0.0
    for motion in range(motions):
        factor = w[G + i] if motions == 1 else factors[motion, i]
        total += np.abs(factor) * remaining[motion]
    return total * w[H + i] * substeps


@register_jitable
def move_lane(blocks, factors, case, source, target):
    """Copy a lane to another place, each given as block and lane."""
    b, i = source
    target_b, target_i = target
    for row in range(0, ROWS * LANES, LANES):
        blocks[target_b, row + target_i] = blocks[b, row + i]
    for motion in range(factors.shape[1]):
        factors[target_b, motion, target_i] = factors[b, motion, i]
    case[target_b, target_i] = case[b, i]


@register_jitable
def retire_finished(
    blocks, width, running, factors, case, compares, remaining, substeps, is_end, outcome, peak
):
    """Store the results of finished lanes, move the others together, and return how many run."""
    count = 0
    for b in range((running + width - 1) // width):
        w = blocks[b]
        for i in range(min(width, running - b * width)):
            status = COMPLETED if is_end else RUNNING
            if w[PEAK + i] > w[A3 + i]:
                status = COLLAPSED
            if status == RUNNING and not compares:  # Eq. (17) is a sum up to the end
                impulse = remaining_impulse(w, i, factors[b], remaining, substeps)
                status = lane_status(w, i, impulse)
            if status == RUNNING:
                if count < b * width + i:
                    move_lane(blocks, factors, case, (b, i), divmod(count, width))
                count += 1
            else:
                number = int(w[LANE + i])
                outcome[number] = status
                peak[number] = np.minimum(w[PEAK + i], w[A3 + i])
    return count


@register_jitable
def shared_loads(ground, first, last, substeps):
    """Return one motion at the steps first - 1 to last; zeros where there is no or another load."""
    loads = np.zeros(last - first + 2)
    if ground.shape[0] == 1 and ground.size > 0:
        for step in range(first - 1, last + 1):
            loads[step - first + 1] = motion_at(ground, 0, step, substeps)
    return loads


@register_jitable
def add_errors(w, width, reference, case, step):
    """Add the term of Eq. (17) at a step."""
    for i in range(width):
        difference = np.abs(reference[case[i], step]) - np.abs(w[X + i])
        w[ERROR + i] += difference * difference


def block_march(advance):
    """Return a function that advances a block by some steps under its load, and sums Eq. (17)."""

    def advance_block(w, width, loads, ground, factors, substeps, first, last, reference, case):
        for step in range(first, last + 1):
            p0 = loads[step - first]
            p1 = loads[step - first + 1]
            if ground.shape[0] > 1:
                add_motions(w, width, ground, factors, step, substeps)
                p0 = 1.0
                p1 = 1.0
            advance(w, width, p0, p1, step)
            if reference.shape[0] > 0:
                add_errors(w, width, reference, case, step)

    return inline(advance_block, advance)


def peaks_march(advance):
    """Return a function that advances the first `running` lanes, and returns how many still run.

    Steps and peaks are those of `full_march`, to the bit. But every `INTERVAL` steps the lanes
    whose answer is known leave, and the others move together. The parameters of the function are
    those of `full_march` and:

    blocks, factors, case
        Lanes change their places in them. Row LANE holds the number of the lane.
    running, steps : int
        Lanes that still run, and the steps of the whole run.
    remaining : ndarray, shape (motions, samples)
        Integral of the absolute value of each motion from a sample to the end, in samples.
    comparison : tuple
        Displacements that Eq. (17) compares with, shape (cases, steps + 1 or more); the row of them
        that belongs to each lane, shape (blocks, width); the steps at which the sums are stored,
        ascending; and the sums, shape (checkpoints, lanes), by the number of the lane. Without
        cases nothing is compared.
    results : tuple of two ndarrays, shape (lanes,)
        Outcome and peak, written for lanes that leave; the peak of a lane that collapsed is a3.
    """

    advance_block = block_march(advance)

    def march_of_peaks(
        blocks,
        width,
        running,
        ground,
        remaining,
        factors,
        substeps,
        first,
        last,
        steps,
        comparison,
        results,
    ):
        reference, case, checkpoints, error = comparison
        outcome, peak = results
        compares = reference.shape[0] > 0
        mark = 0
        while mark < checkpoints.size - 1 and checkpoints[mark] < first:
            mark += 1
        while first <= last and running > 0:
            stop = min(first + INTERVAL - 1, last)
            if compares and checkpoints[mark] >= first:
                stop = min(stop, checkpoints[mark])
            loads = shared_loads(ground, first, stop, substeps)
            for b in range((running + width - 1) // width):
                w = blocks[b]
                lanes = min(width, running - b * width)
                if width >= VECTOR:
                    lanes = (lanes + VECTOR - 1) // VECTOR * VECTOR
                advance_block(
                    w, lanes, loads, ground, factors[b], substeps, first, stop, reference, case[b]
                )
                if compares and stop == checkpoints[mark]:
                    for i in range(min(width, running - b * width)):
                        error[mark, int(w[LANE + i])] = w[ERROR + i]
            if compares and stop == checkpoints[mark]:
                mark = min(mark + 1, checkpoints.size - 1)
            sample = min(stop // substeps, remaining.shape[1] - 1)
            running = retire_finished(
                blocks,
                width,
                running,
                factors,
                case,
                compares,
                remaining[:, sample],
                substeps,
                stop == steps,
                outcome,
                peak,
            )
            first = stop + 1
        return running

    return inline(march_of_peaks, advance)


# --- walls with an uneven force -------------------------------------------------------------------


@register_jitable
def uneven_lane_collapses(lane, ground, vertical):
    """Tell if a lane of `uneven_march` collapses."""
    k1, b1, ks, a1, a2, a3, e, h, substeps, load, lift, positive, negative = lane
    curve = (k1, b1, ks, a1, a2, a3)
    parts = int(substeps)
    x = 0.0
    v = 0.0
    end = load * ground[0]
    a = end
    for sample in range(ground.size - 1):
        for part in range(1, parts + 1):
            share = part / parts
            start = end
            end = load * (ground[sample] + (ground[sample + 1] - ground[sample]) * share)
            rest = h
            x_end = x + h * (v + 0.5 * h * a)
            if crosses_zero(x, x_end):
                s = time_to_impact(x, v, a, h)
                impact_a = start + (end - start) * (s / h)  # at x = 0 only the load accelerates
                v += 0.5 * s * (a + impact_a)
                v *= e
                a = impact_a
                rest = h - s
                x_end = rest * (v + 0.5 * rest * a)
            x = x_end
            scale = negative if x < 0.0 else positive
            z = np.abs(x) / scale
            if z > a3:
                return True
            vertical_end = vertical[sample] + (vertical[sample + 1] - vertical[sample]) * share
            restoring = signed(x, scale * force(z, curve)) * max(1.0 + lift * vertical_end, 0.0)
            v = v + 0.5 * rest * (a + end - restoring)
            a = end - restoring
    return False


def uneven_lanes(lanes, ground, vertical, collapsed):
    """Write which lanes collapse under restitution, each from rest up to its collapse.

    A wall may be stronger to one side than to the other, and vertical shaking may change its
    weights. The scheme is that of `impact_step`.

    Parameters
    ----------
    lanes : ndarray, shape (lanes, 13)
        Curve; e; step in tau and substeps; factors on both motions; scale factors of the curve for
        u > 0 and u < 0, in force and displacement alike.
    ground, vertical : ndarray, shape (samples,)
        Horizontal and vertical acceleration.
    collapsed : ndarray of bool, shape (lanes,)
        Result.
    """
    for i in range(lanes.shape[0]):
        collapsed[i] = uneven_lane_collapses(lanes[i], ground, vertical)


# --- the compiled entries -------------------------------------------------------------------------


def block_steps(update):
    """Return the functions that advance a block, by scheme and damper."""
    steps = {}
    for name, formula in COEFFICIENTS.items():
        steps["newmark", name] = block_step(viscous_step(formula), update)
        steps["paper", name] = block_step(paper_step(formula), update)
    steps["newmark", "cdc"] = block_step(constant_step, update)
    for name, law in RESTITUTIONS.items():
        steps["newmark", name] = block_step_with_impacts(law, update)
        steps["paper", name] = block_step(paper_impact_step(law), update)
    return steps


FULL: dict[tuple[str, str], Callable[..., Any]] = {}  # marches with histories, by scheme and damper
PEAKS: dict[tuple[str, str], Callable[..., Any]] = {}  # marches of peaks
for (scheme, damper), advance in block_steps(update_all).items():
    FULL[scheme, damper] = compile_entry(f"full_{scheme}_{damper}", full_march(advance))
for (scheme, damper), advance in block_steps(update_peak).items():
    PEAKS[scheme, damper] = compile_entry(f"peaks_{scheme}_{damper}", peaks_march(advance))
uneven_march = compile_entry("uneven_march", uneven_lanes)
