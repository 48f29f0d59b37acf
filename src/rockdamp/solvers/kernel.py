"""The batched solver's compiled code: steps of one lane, both marches, and a compiled entry for each damper.

A *lane* is one time history: one wall, one damper, one release. A history alone waits for each operation's result
before the next can begin; a processor's vector unit computes several at once. So lanes advance together in blocks of
up to `LANES`, and a loop over the lanes of a block has choices between computed values in place of branches. A block is
one flat array of rows, a row for each variable: variable R of lane i is block[R + i]. The result of a lane does not
depend on its neighbours, on the number of lanes or on the number of threads.

`viscous(coefficient)` and `impact(kept)` make the step of a lane, `block_step` the loop over a block, `full_march` and
`peaks_march` the loop over the steps; the last lines compile them, one for each damper and march. Machine code is kept
by Numba, which recompiles where *this file* changes and notices no other: nothing is imported into it but NumPy
and Numba, neither functions nor numbers.

Everything is dimensionless: x = u/u_ins, tau = p t, unit mass, f = F/(K0 u_ins). Symbols are the paper's: a1, b1, a3
shape the curve, k1 = b1/a1 is the first branch's stiffness, ks the softening branch's, taken positive.
"""

import numpy as np
from numba import njit
from numba.extending import register_jitable

LANES = 64  # of a block at most, and the distance of its rows
VECTOR = 8  # lanes that are computed at once: the width of a block of four or more lanes is a multiple of it
ROWS = 22
X, V, A, ALIVE, END, PEAK, PEAK_AT, CROSSINGS, ERROR = (LANES * row for row in range(9))
K1, B1, KS, A1, A2, A3 = (
    LANES * row for row in range(9, 15)
)  # in the order of `TrilinearCurve.parameters`
H, G, G_BEFORE = (
    LANES * row for row in range(15, 18)
)  # step; factor on the motion, or loads of several motions
P0, P1, P2 = (LANES * row for row in range(18, 21))  # the damper's parameters
DAMPER = LANES * 21  # its place in `DAMPERS`, which the paper's scheme alone reads
LANE = CROSSINGS  # the lane's number, in the march of peaks

TINY = (
    1e-100  # keeps 0/0 away at x = 0; its square and the square's inverse are still normal numbers
)
INTERVAL = 128  # steps after which finished lanes leave the march of peaks
COMPLETED, COLLAPSED, RUNNING = 0, 1, -1


def entry(name, function):
    """Compile a function under a name of its own, by which Numba keeps its machine code."""
    function.__name__ = function.__qualname__ = name
    # Allow FMA but no reassociation, so that a result does not depend on the batch.
    return njit(
        error_model="numpy", nogil=True, fastmath={"nnan", "ninf", "nsz", "contract"}, cache=True
    )(function)


def inlined(function, *parts):
    """Let compiled code call a function that a template made, under a name of its own.

    Numba tells machine code apart by names: two functions of one name, of which one was read from the cache, would be
    taken for each other.
    """
    function.__qualname__ = "_".join([function.__name__, *(part.__qualname__ for part in parts)])
    return register_jitable(function)


# --- the curve --------------------------------------------------------------------------------------------------------


@register_jitable
def force(z, curve):
    """Return the restoring force at z = |x|: the lowest of the three lines, zero beyond a3."""
    k1, b1, ks, _, _, a3 = curve
    return np.maximum(np.minimum(np.minimum(k1 * z, b1), ks * (a3 - z)), 0.0)


@register_jitable
def tangent(z, curve):
    """Return the slope of the force; at a corner that of the branch further out."""
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


# --- the dampers ------------------------------------------------------------------------------------------------------
# A coefficient C takes z = |x|, f(z), 2V(z), the velocity v away from x = 0, the step h, and the three parameters of
# `Damping.kernel_arguments`. What it does not use costs nothing.


@register_jitable
def cdc(z, f, double_v, v, h, p):
    return p[0]


@register_jitable
def cdr(z, f, double_v, v, h, p):
    return p[0] * np.sqrt(f / z)


@register_jitable
def sdr(z, f, double_v, v, h, p):
    return p[0] * (f / z)


@register_jitable
def ecd(z, f, double_v, v, h, p):
    """ECD of order 0, without a phase."""
    return p[0] * np.sqrt(f * f / double_v)


@register_jitable
def phase_coefficient(size, f, double_v, v, inverse, has_phase):
    """Return w_E size/(1 - size sin cos) of the phase, tan phi = sqrt(V/T), with kappa cos^2m as the size."""
    root = np.sqrt(double_v)
    return size * f / (root * (1.0 - np.minimum(size * v * root * inverse, 0.95) * has_phase))


@register_jitable
def ecd_doubled(z, f, double_v, v, h, p):
    """ECD of an order that is a power of 2, from 1 to 128: squares, which the compiler makes vectors of."""
    m, inverse = p[1], 1.0 / (v * v + double_v)
    power = v * v * inverse
    power = power * power if m >= 2.0 else power
    power = power * power if m >= 4.0 else power
    power = power * power if m >= 8.0 else power
    power = power * power if m >= 16.0 else power
    power = power * power if m >= 32.0 else power
    power = power * power if m >= 64.0 else power
    power = power * power if m >= 128.0 else power
    return phase_coefficient(p[0] * power, f, double_v, v, inverse, 1.0)


@register_jitable
def ecd_any(z, f, double_v, v, h, p):
    """ECD of any order m and any exponent g of the loss, in one batch; where both are 0 there is no phase."""
    _, m, g = p
    inverse = 1.0 / (v * v + double_v)
    return phase_coefficient(
        p[0] * inverse**g * (v * v * inverse) ** m, f, double_v, v, inverse, m + g > 0.0
    )


@register_jitable
def band(z, f, double_v, v, h, p):
    """BAND: size (1 - (z/(c v))^2); at rest the size at z = 0, and 0 elsewhere."""
    r = np.minimum(z / np.maximum(p[1] * np.abs(v), 1e-90), 1.0)
    return p[0] * (1.0 - r * r)


@register_jitable
def cqd(z, f, double_v, v, h, p):
    """CQD in a step h: the integral of mu from z - h v/2 to z + h v/2, over h, lest a step pass the band."""
    half = 0.5 * h * v
    a = np.minimum(np.maximum((z - half) / p[1], -1.0), 1.0)
    b = np.minimum(np.maximum((z + half) / p[1], -1.0), 1.0)
    return p[0] * np.abs((b - a) * (1.0 - (a * a + a * b + b * b) / 3.0)) / h


@register_jitable
def cr(v, p):
    """Return what an impact at the speed v leaves of it: e."""
    return p[0]


@register_jitable
def cr_law(v, p):
    """Return the same where the loss depends on the energy: E+^g = E-^g - E_r^g (1 - e^2g), and 0 where none is left.

    Written by the quotient of the energies, which is well conditioned down to g = 0.
    """
    e, g, double_reference = p
    steep = np.minimum(
        g * np.log(double_reference / np.maximum(v * v, 1e-200)), 700.0
    )  # far beyond a stop
    left = np.exp(steep) * np.expm1(2.0 * g * np.log(e))
    kept = np.exp(np.log1p(np.maximum(left, -1.0 + 1e-16)) / np.maximum(2.0 * g, 1e-300))
    kept = kept if left > -1.0 else 0.0
    return e if g == 0.0 else kept


# --- one step of one lane ---------------------------------------------------------------------------------------------
# A step takes the lane's state, its step, its load at both ends, its curve and its damper's parameters. It returns
# displacement, velocity and acceleration at its end.


@register_jitable
def odd(x, f):
    """Return f with the sign of x: the force of f(|x|), and of a velocity how fast the wall moves away from x = 0."""
    return -f if x < 0.0 else f


@register_jitable(fastmath=False)
def product(one, other):
    """Round a product before it enters a sum, alike in a vector of lanes and in a lane alone."""
    return one * other


@register_jitable
def ahead(x, v, a, h):
    """Return the displacement after a step at a constant acceleration."""
    return x + product(h, v + 0.5 * h * a)


@register_jitable
def crossed(before, after):
    """Tell if a step has reached or passed x = 0. By signs, as the product underflows late in a decay."""
    return ((before > 0.0) & (after <= 0.0)) | ((before < 0.0) & (after >= 0.0))


@register_jitable
def time_to_impact(x, v, a, h):
    """Return the time from the start of the step to the root of x + v s + a s^2/2, known to lie in (0, h]."""
    away = v if x > 0.0 else -v
    root = np.sqrt(np.maximum(v * v - 2.0 * a * x, 0.0))
    return np.minimum(2.0 * np.abs(x) / np.maximum(root - away, TINY), h)


@register_jitable
def newmark_end(v, a, h, load, restoring, c):
    """Explicit Newmark (beta 0, gamma 1/2): velocity and acceleration at the end of a step, its displacement known."""
    half = v + 0.5 * h * a
    a = (load - restoring - c * half) / (1.0 + 0.5 * h * c)
    return half + 0.5 * h * a, a


def viscous(coefficient):
    """Explicit Newmark; C at the displacement at the end of the step and the velocity v + h a expected there."""

    def viscous_step(x, v, a, h, start, end, curve, damper, number):
        x = x + h * (v + 0.5 * h * a)
        z = np.maximum(np.abs(x), TINY)
        f = force(z, curve)
        c = coefficient(z, f, double_energy(z, curve), odd(x, v + h * a), h, damper)
        v, a = newmark_end(v, a, h, end, odd(x, f), c)
        return x, v, a

    return inlined(viscous_step, coefficient)


@register_jitable
def constant_step(x, v, a, h, start, end, curve, damper, number):
    """The same for a constant C, which needs no z > 0: the maximum would cost a tenth of the time."""
    x = x + h * (v + 0.5 * h * a)
    v, a = newmark_end(v, a, h, end, odd(x, force(np.abs(x), curve)), damper[0])
    return x, v, a


@register_jitable
def free_step(x, v, a, h, start, end, curve, damper, number):
    """CR without an impact: Newmark without damping."""
    x = ahead(x, v, a, h)
    v, a = newmark_end(v, a, h, end, odd(x, force(np.abs(x), curve)), 0.0)
    return x, v, a


def impact(kept):
    """CR, Eq. (8), the impact located inside the step: Newmark up to it, the velocity times e, Newmark after it."""

    def impact_step(x, v, a, h, start, end, curve, damper, number):
        hit = crossed(x, ahead(x, v, a, h))
        s = time_to_impact(x, v, a, h) if hit else 0.0
        load = start + (end - start) * (s / h)  # at x = 0 the restoring force vanishes
        v = v + 0.5 * s * (a + load) if hit else v
        v = kept(v, damper) * v if hit else v
        a = load if hit else a
        return free_step(0.0 if hit else x, v, a, h - s, start, end, curve, damper, number)

    return inlined(impact_step, kept)


DAMPERS = ("cr", "cr_law", "cdc", "cdr", "sdr", "ecd", "ecd_doubled", "ecd_any", "band", "cqd")


@register_jitable
def any_coefficient(z, f, double_v, v, h, p, number):
    """Return C of the damper at a place of `DAMPERS`; 0 of CR."""
    if number < 2.0:
        return 0.0
    if number == 2.0:
        return cdc(z, f, double_v, v, h, p)
    if number == 3.0:
        return cdr(z, f, double_v, v, h, p)
    if number == 4.0:
        return sdr(z, f, double_v, v, h, p)
    if number == 5.0:
        return ecd(z, f, double_v, v, h, p)
    if number == 6.0:
        return ecd_doubled(z, f, double_v, v, h, p)
    if number == 8.0:
        return band(z, f, double_v, v, h, p)
    if number == 9.0:
        return cqd(z, f, double_v, v, h, p)
    return ecd_any(z, f, double_v, v, h, p)


@register_jitable
def linear_acceleration(v, a, h, dp, k, c):
    """Return increments of displacement and velocity by linear acceleration, stiffness and damping frozen in a step."""
    dx = (dp + 6.0 * v / h + 3.0 * a + c * (3.0 * v + 0.5 * h * a)) / (
        k + 3.0 * c / h + 6.0 / (h * h)
    )
    return dx, 3.0 * dx / h - 3.0 * v - 0.5 * h * a


@register_jitable
def paper_step(x, v, a, h, start, end, curve, damper, number):
    """The scheme as printed: linear acceleration without iteration, C and the tangent frozen at the step's start.

    The velocity is multiplied by e at the end of the step, and balance is restored there.
    """
    # ASSUME: the acceleration at the end of the step comes from the balance of forces there, not from the increment.
    k = tangent(np.abs(x), curve)
    if number < 2.0:
        dx, dv = linear_acceleration(v, a, h, end - start, k, 0.0)
        before, x, v = x, x + dx, v + dv
        if crossed(before, x):
            v = (cr(v, damper) if number == 0.0 else cr_law(v, damper)) * v
        return x, v, end - odd(x, force(np.abs(x), curve))
    z = np.maximum(np.abs(x), TINY)
    c = any_coefficient(z, force(z, curve), double_energy(z, curve), odd(x, v), h, damper, number)
    dx, dv = linear_acceleration(v, a, h, end - start, k, c)
    x, v = x + dx, v + dv
    z = np.maximum(np.abs(x), TINY)
    f = force(z, curve)
    c = any_coefficient(z, f, double_energy(z, curve), odd(x, v), h, damper, number)
    return x, v, end - odd(x, f) - c * v


# --- one step of a block ----------------------------------------------------------------------------------------------


@register_jitable
def keep_all(w, i, x, v, a, step):
    """Take the new state unless the wall has collapsed; note its peak, crossings of x = 0, and collapse beyond a3."""
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
def keep_peak(w, i, x, v, a, step):
    """Take the new state and note the peak."""
    w[X + i], w[V + i], w[A + i] = x, v, a
    # The peak's own size: a value just read would be stored only where it changes, by masks, which take several times
    # as long on some processors.
    w[PEAK + i] = np.maximum(np.abs(w[PEAK + i]), np.abs(x))


def block_step(lane_step, keep):
    """Return a function that advances each lane of a block, from the motion p0 to p1."""

    def advance(w, width, p0, p1, step):
        for i in range(width):
            curve = w[K1 + i], w[B1 + i], w[KS + i], w[A1 + i], w[A2 + i], w[A3 + i]
            start, end = product(w[G_BEFORE + i], p0), product(w[G + i], p1)
            damper = w[P0 + i], w[P1 + i], w[P2 + i]
            x, v, a = lane_step(
                w[X + i], w[V + i], w[A + i], w[H + i], start, end, curve, damper, w[DAMPER + i]
            )
            keep(w, i, x, v, a, step)

    return inlined(advance, lane_step, keep)


def block_step_with_impacts(kept, keep):
    """Return the same for CR. In few steps any lane has an impact; the others need no root or division."""
    hit, free = block_step(impact(kept), keep), block_step(free_step, keep)

    def advance_with_impacts(w, width, p0, p1, step):
        impacts = 0
        for i in range(width):
            impacts += crossed(w[X + i], ahead(w[X + i], w[V + i], w[A + i], w[H + i]))
        if impacts > 0:
            hit(w, width, p0, p1, step)
        else:
            free(w, width, p0, p1, step)

    return inlined(advance_with_impacts, kept, keep)


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
    """Move each lane's load to the start of the step, and sum its motions at the end of it."""
    for i in range(width):
        w[G_BEFORE + i], w[G + i] = w[G + i], 0.0
    for motion in range(ground.shape[0]):
        acceleration = motion_at(ground, motion, step, substeps)
        for i in range(width):
            w[G + i] += factors[motion, i] * acceleration


# --- the march with histories -----------------------------------------------------------------------------------------


@register_jitable
def store(w, width, at, displacement, velocity):
    """Store the state of the lanes that have not collapsed, as number `at`."""
    for i in range(width):
        if w[ALIVE + i] > 0.0:
            displacement[i, at], velocity[i, at] = w[X + i], w[V + i]


def full_march(advance):
    """Return a function that advances blocks by the steps `first` to `last`, in place; the first of a run is step 1.

    Its parameters
    --------------
    blocks, width : ndarray, shape (blocks, ROWS * LANES), and int
        The rows above; lanes of each block.
    ground : ndarray, shape (motions, samples)
        Shared accelerations, linear between samples; empty for a free decay. Of one motion, rows G and G_BEFORE hold
        each lane's factor on it; of several, its loads at the end of the step and at its start.
    factors : ndarray, shape (blocks, motions, width)
        Of several motions, each lane's factors on them.
    substeps, first, last : int
        Steps per sample of `ground`; and the steps to take.
    every, displacement, velocity : int and ndarray, shape (blocks, width, last//every + 1 or more)
        Histories at each `every`-th step. After a collapse they stay as they were made.
    """

    def march(blocks, width, ground, factors, substeps, first, last, every, displacement, velocity):
        forced, motions = ground.size > 0, ground.shape[0]
        for b in range(blocks.shape[0]):
            w = blocks[b]
            p1 = motion_at(ground, 0, first - 1, substeps) if forced else 0.0
            if first == 1:
                store(w, width, 0, displacement[b], velocity[b])
            for step in range(first, last + 1):
                p0 = p1
                if motions > 1:
                    add_motions(w, width, ground, factors[b], step, substeps)
                    p0, p1 = 1.0, 1.0
                elif forced:
                    p1 = motion_at(ground, 0, step, substeps)
                advance(w, width, p0, p1, step)
                if step % every == 0:
                    store(w, width, step // every, displacement[b], velocity[b])
                if step % 256 == 0:  # does any wall of the block still stand?
                    standing = 0.0
                    for i in range(width):
                        standing += w[ALIVE + i]
                    if standing == 0.0:
                        break

    return inlined(march, advance)


# --- the march of peaks -----------------------------------------------------------------------------------------------


@register_jitable
def lane_status(w, i, impulse):
    """Return COLLAPSED, COMPLETED (it cannot exceed its peak any more) or RUNNING.

    Dampers and impacts only take energy, and a load p raises sqrt(v^2 + 2V(x)) by at most its impulse, the integral of
    |p| from now to the end. If that sum, by a hundredth larger, is less than sqrt(2V(peak)), the rest is not needed. At
    steps of w1 h > 0.1 the corners of the curve feed energy in, and no lane may leave early.
    """
    if w[PEAK + i] > w[A3 + i]:
        return COLLAPSED
    if w[H + i] * w[H + i] * w[K1 + i] > 0.1 * 0.1:
        return RUNNING
    curve = w[K1 + i], w[B1 + i], w[KS + i], w[A1 + i], w[A2 + i], w[A3 + i]
    largest = double_energy(w[PEAK + i], curve)
    if 1.01 * impulse * (1.01 * impulse) >= largest:  # early in a record this answers for most
        return RUNNING
    speed = np.sqrt(w[V + i] * w[V + i] + double_energy(np.abs(w[X + i]), curve)) + impulse
    return COMPLETED if 1.01 * speed < np.sqrt(largest) else RUNNING


@register_jitable
def impulse_left(w, i, factors, remaining, substeps):
    """Return the integral of a lane's |p| over what remains of its motions, which is given in samples."""
    motions = remaining.size
    total = 0.0
    for motion in range(motions):
        total += np.abs(w[G + i] if motions == 1 else factors[motion, i]) * remaining[motion]
    return total * w[H + i] * substeps


@register_jitable
def retire_finished(
    blocks, width, running, factors, case, remaining, substeps, is_end, outcome, peak
):
    """Store the results of finished lanes and move the others together; return how many still run."""
    kept = 0
    b, i, to_b, to_i = 0, -1, 0, 0
    for lane in range(running):
        i += 1
        if i == width:
            b, i = b + 1, 0
        w = blocks[b]
        status = COLLAPSED if w[PEAK + i] > w[A3 + i] else COMPLETED if is_end else RUNNING
        if status == RUNNING and case.shape[0] == 0:  # Eq. (17) is a sum up to the end
            status = lane_status(w, i, impulse_left(w, i, factors[b], remaining, substeps))
        if status == RUNNING:
            if kept < lane:
                for row in range(0, ROWS * LANES, LANES):
                    blocks[to_b, row + to_i] = blocks[b, row + i]
                for motion in range(factors.shape[1]):
                    factors[to_b, motion, to_i] = factors[b, motion, i]
                if case.shape[0] > 0:
                    case[to_b, to_i] = case[b, i]
            kept, to_i = kept + 1, to_i + 1
            if to_i == width:
                to_b, to_i = to_b + 1, 0
        else:
            number = int(w[LANE + i])
            outcome[number] = status
            peak[number] = np.minimum(w[PEAK + i], w[A3 + i])
    return kept


@register_jitable
def add_errors(w, width, reference, case, step):
    """Add this step's term of Eq. (17)."""
    for i in range(width):
        difference = np.abs(reference[case[i], step]) - np.abs(w[X + i])
        w[ERROR + i] += difference * difference


def peaks_march(advance):
    """Return a function that advances the first `running` lanes by some steps, and returns how many go on.

    The steps are those of `full_march`, and so is each lane's peak, to the bit. But every `INTERVAL` steps the lanes
    leave whose answer is known, and the others move together.

    Its parameters
    --------------
    blocks, width, ground, factors, substeps, first, last
        As for `full_march`. Row LANE holds the lane's number. Lanes change their places in blocks, factors and case.
    running, steps : int
        Lanes that still run, and the steps of the whole run.
    remaining : ndarray, shape (motions, samples)
        The integral of each motion's absolute value from a sample to the end, with samples as the unit of time.
    comparison : four ndarrays
        Displacements that Eq. (17) compares with, shape (cases, steps + 1 or more), each lane's row of them, shape
        (blocks, width), the steps at which the sums are stored, ascending, and the sums, shape (checkpoints, lanes), by
        the lane's number. No cases, no comparison.
    results : two ndarrays, shape (lanes,)
        Outcome and peak, written for lanes that leave; the peak of a lane that collapsed is a3.
    """

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
        motions, compare, mark = ground.shape[0], reference.shape[0] > 0, 0
        while mark < checkpoints.size - 1 and checkpoints[mark] < first:
            mark += 1
        while first <= last and running > 0:
            stop = min(first + INTERVAL - 1, last)
            if compare and checkpoints[mark] >= first:
                stop = min(stop, checkpoints[mark])
            loads = np.zeros(stop - first + 2)
            if motions == 1 and ground.size > 0:
                for step in range(first - 1, stop + 1):
                    loads[step - first + 1] = motion_at(ground, 0, step, substeps)
            for b in range((running + width - 1) // width):
                w, lanes = blocks[b], min(width, running - b * width)
                lanes = lanes if width < VECTOR else (lanes + VECTOR - 1) // VECTOR * VECTOR
                for step in range(first, stop + 1):
                    p0, p1 = loads[step - first], loads[step - first + 1]
                    if motions > 1:
                        add_motions(w, lanes, ground, factors[b], step, substeps)
                        p0, p1 = 1.0, 1.0
                    advance(w, lanes, p0, p1, step)
                    if compare:
                        add_errors(w, lanes, reference, case[b], step)
                if compare and stop == checkpoints[mark]:
                    for i in range(min(width, running - b * width)):
                        error[mark, int(w[LANE + i])] = w[ERROR + i]
            if compare and stop == checkpoints[mark]:
                mark = min(mark + 1, checkpoints.size - 1)
            left = remaining[:, min(stop // substeps, remaining.shape[1] - 1)]
            is_end = stop == steps
            running = retire_finished(
                blocks, width, running, factors, case, left, substeps, is_end, outcome, peak
            )
            first = stop + 1
        return running

    return inlined(march_of_peaks, advance)


# --- walls of an uneven force -----------------------------------------------------------------------------------------


@register_jitable
def uneven_lane_collapses(lane, ground, vertical):
    """Tell if a lane of `uneven_lanes` collapses."""
    k1, b1, ks, a1, a2, a3, e, h, substeps, load, lift, positive, negative = lane
    curve, parts = (k1, b1, ks, a1, a2, a3), int(substeps)
    x, v, end = 0.0, 0.0, load * ground[0]
    a = end
    for sample in range(ground.size - 1):
        for part in range(1, parts + 1):
            share = part / parts
            start, end = (
                end,
                load * (ground[sample] + (ground[sample + 1] - ground[sample]) * share),
            )
            rest, moved = h, x + h * (v + 0.5 * h * a)
            if crossed(x, moved):
                until = time_to_impact(x, v, a, h)
                at = start + (end - start) * (
                    until / h
                )  # at x = 0 the acceleration is the load's alone
                v += 0.5 * until * (a + at)
                v *= e
                a, rest = at, h - until
                moved = rest * (v + 0.5 * rest * a)
            x = moved
            scale = negative if x < 0.0 else positive
            z = np.abs(x) / scale
            if z > a3:
                return True
            up = vertical[sample] + (vertical[sample + 1] - vertical[sample]) * share
            pull = odd(x, scale * force(z, curve)) * max(1.0 + lift * up, 0.0)
            v, a = v + 0.5 * rest * (a + end - pull), end - pull
    return False


def uneven_lanes(lanes, ground, vertical, collapsed):
    """Write which lanes collapse under restitution, each up to its collapse, from rest.

    A wall may be stronger to one side than to the other, and vertical shaking may change its weights. The scheme is
    that of `impact`.

    Parameters
    ----------
    lanes : ndarray, shape (lanes, 13)
        Curve; e; step in tau and substeps; factors on both motions; what times the curve is that of u > 0, and of
        u < 0, in force and displacement alike.
    ground, vertical : ndarray, shape (samples,)
    collapsed : ndarray of bool, shape (lanes,)
    """
    for i in range(lanes.shape[0]):
        collapsed[i] = uneven_lane_collapses(lanes[i], ground, vertical)


uneven_march = entry("uneven_march", uneven_lanes)


# --- the compiled entries ---------------------------------------------------------------------------------------------

full_cr_march = full_march(block_step_with_impacts(cr, keep_all))
full_cr_law_march = full_march(block_step_with_impacts(cr_law, keep_all))
full_cdc_march = full_march(block_step(constant_step, keep_all))
full_cdr_march = full_march(block_step(viscous(cdr), keep_all))
full_sdr_march = full_march(block_step(viscous(sdr), keep_all))
full_ecd_march = full_march(block_step(viscous(ecd), keep_all))
full_ecd_doubled_march = full_march(block_step(viscous(ecd_doubled), keep_all))
full_ecd_any_march = full_march(block_step(viscous(ecd_any), keep_all))
full_band_march = full_march(block_step(viscous(band), keep_all))
full_cqd_march = full_march(block_step(viscous(cqd), keep_all))
full_paper_march = full_march(block_step(paper_step, keep_all))
peaks_cr_march = peaks_march(block_step_with_impacts(cr, keep_peak))
peaks_cr_law_march = peaks_march(block_step_with_impacts(cr_law, keep_peak))
peaks_cdc_march = peaks_march(block_step(constant_step, keep_peak))
peaks_cdr_march = peaks_march(block_step(viscous(cdr), keep_peak))
peaks_sdr_march = peaks_march(block_step(viscous(sdr), keep_peak))
peaks_ecd_march = peaks_march(block_step(viscous(ecd), keep_peak))
peaks_ecd_doubled_march = peaks_march(block_step(viscous(ecd_doubled), keep_peak))
peaks_ecd_any_march = peaks_march(block_step(viscous(ecd_any), keep_peak))
peaks_band_march = peaks_march(block_step(viscous(band), keep_peak))
peaks_cqd_march = peaks_march(block_step(viscous(cqd), keep_peak))
peaks_paper_march = peaks_march(block_step(paper_step, keep_peak))

full_cr = entry("full_cr", lambda *arguments: full_cr_march(*arguments))
full_cr_law = entry("full_cr_law", lambda *arguments: full_cr_law_march(*arguments))
full_cdc = entry("full_cdc", lambda *arguments: full_cdc_march(*arguments))
full_cdr = entry("full_cdr", lambda *arguments: full_cdr_march(*arguments))
full_sdr = entry("full_sdr", lambda *arguments: full_sdr_march(*arguments))
full_ecd = entry("full_ecd", lambda *arguments: full_ecd_march(*arguments))
full_ecd_doubled = entry("full_ecd_doubled", lambda *arguments: full_ecd_doubled_march(*arguments))
full_ecd_any = entry("full_ecd_any", lambda *arguments: full_ecd_any_march(*arguments))
full_band = entry("full_band", lambda *arguments: full_band_march(*arguments))
full_cqd = entry("full_cqd", lambda *arguments: full_cqd_march(*arguments))
full_paper = entry("full_paper", lambda *arguments: full_paper_march(*arguments))
peaks_cr = entry("peaks_cr", lambda *arguments: peaks_cr_march(*arguments))
peaks_cr_law = entry("peaks_cr_law", lambda *arguments: peaks_cr_law_march(*arguments))
peaks_cdc = entry("peaks_cdc", lambda *arguments: peaks_cdc_march(*arguments))
peaks_cdr = entry("peaks_cdr", lambda *arguments: peaks_cdr_march(*arguments))
peaks_sdr = entry("peaks_sdr", lambda *arguments: peaks_sdr_march(*arguments))
peaks_ecd = entry("peaks_ecd", lambda *arguments: peaks_ecd_march(*arguments))
peaks_ecd_doubled = entry(
    "peaks_ecd_doubled", lambda *arguments: peaks_ecd_doubled_march(*arguments)
)
peaks_ecd_any = entry("peaks_ecd_any", lambda *arguments: peaks_ecd_any_march(*arguments))
peaks_band = entry("peaks_band", lambda *arguments: peaks_band_march(*arguments))
peaks_cqd = entry("peaks_cqd", lambda *arguments: peaks_cqd_march(*arguments))
peaks_paper = entry("peaks_paper", lambda *arguments: peaks_paper_march(*arguments))
