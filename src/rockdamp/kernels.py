"""The compiled code of the batched solver: the tri-linear curve, the dampers, one step of each scheme, and the loop
over steps and lanes; beside them the reader of a table.

A *lane* is one time history: one wall, one damper, one release. Lanes advance together in blocks of up to `LANES`, and
every loop over the lanes of a block is free of branches and allocations, so that the compiler vectorises it. Each lane
is computed by the same formulas whatever runs beside it, or by ones that give the same bits: its result does not depend
on its neighbours, on the number of lanes or on the number of threads.

Everything here is dimensionless: x = u/u_ins, tau = p t, unit mass, so f = F/(K0 u_ins). Symbols are the paper's:
a1, b1, a3 shape the curve, k1 = b1/a1 is the first branch's stiffness, ks the softening branch's (positive).

The functions of the curve and of the dampers are plain Python that numba compiles in place: the same lines serve NumPy
arrays elsewhere, the dampers' with a mapping of rows in place of a block.

The loop is compiled once for each kind of step, of one damper's formula each. So a step pays for what its damper needs,
a damper that is added leaves the machine code of the others as it is, and who uses one damper waits for no other.

All of it stays in this one file: numba's cache does not notice an edit of a function in another file.
"""

from functools import cache

import numpy as np
from numba import njit
from numba.extending import register_jitable

from rockdamp.storage.compiled_cache import checked, digest_of

SOURCE = digest_of(__file__)  # as it is imported; an edit while this process runs changes nothing here

LANES = 64  # of a block at most, and the distance of its rows
# Of a block: up to three lanes are computed one after the other, more of them in vectors, which are filled up.
WIDTHS = (1, 2, 3, 8, 16, 32, 48, LANES)

# A block of lanes is one flat array, so that the compiler sees that its rows cannot overlap: row r of lane i is
# block[r + i]. First the state, then what is observed, then the parameters.
ROWS = 25
X, V, A, ALIVE, END, PEAK, PEAK_AT, CROSSINGS, ERROR = (LANES * row for row in range(9))
K1, B1, KS, A1, A2, A3, H, G, E = (LANES * row for row in range(9, 18))
C0, C1, C2, BY_ENERGY, HALF_N, ORDER, G_BEFORE = (LANES * row for row in range(18, 25))
CURVE = (K1, B1, KS, A1, A2, A3)  # in the order of `TrilinearCurve.parameters`

PATIENCE = 256  # steps after which a block is asked whether any of its walls still stands

TINY = 1e-100  # keeps 0/0 away at x = 0; its square and the square's inverse are still normal numbers


# --- a power, which numba would compute one lane at a time ----------------------------------------------------------

# Of x = 2^e m, m from sqrt(1/2) to sqrt(2): log2(m)/s by s^2, s = (m - 1)/(m + 1), and 2^r, |r| <= 1/2, by r. Both
# interpolate at Chebyshev's points, to 1.5e-17 and 2.1e-17 of the value; the highest power comes first. They are made
# by tools/power_coefficients.py.
LOG2 = (
    0.2136589569431927,
    0.2209130842311768,
    0.262334352504183,
    0.32059853491395984,
    0.4121985858409005,
    0.5770780163455203,
    0.9617966939259898,
    2.8853900817779268,
)
EXP2 = (
    2.5729324177362305e-11,
    4.4558179083360645e-10,
    7.0548973041554995e-09,
    1.0178057087733941e-07,
    1.3215486808705563e-06,
    1.5252733841556773e-05,
    0.00015403530393370734,
    0.001333355814640647,
    0.00961812910762848,
    0.055504108664821625,
    0.24022650695910072,
    0.6931471805599453,
    1.0,
)
# Numba is told to inline what calls it: it is longer than what LLVM inlines by itself, and a call ends the vector loop.
# Of a double's bits: the exponent stands above FRACTION bits, with 1023 added.
FRACTION = 52
ONE = 0x3FF0000000000000  # of 1.0
BELOW_ONE = ONE - 0x3FE6A09E667F3BCD  # from sqrt(1/2) to 1.0
UNITS = 0x4330000000000000  # of 2^52, whose last bits count units
SHIFTED = 2.0**52 + 1023.0
SMALLEST, LOWEST, HIGHEST = 2.0**-1022, -1022.0, 1023.0  # what is a normal number, and its exponents


@register_jitable(forceinline=True)
def log2_over_s(q):
    """log2(m)/s by q = s^2."""
    c = LOG2
    return ((((((c[0] * q + c[1]) * q + c[2]) * q + c[3]) * q + c[4]) * q + c[5]) * q + c[6]) * q + c[7]


@register_jitable(forceinline=True)
def exp2_within(r):
    """2^r of |r| <= 1/2."""
    c = EXP2
    high = (((((c[0] * r + c[1]) * r + c[2]) * r + c[3]) * r + c[4]) * r + c[5]) * r + c[6]
    return (((((high * r + c[7]) * r + c[8]) * r + c[9]) * r + c[10]) * r + c[11]) * r + c[12]


@register_jitable(forceinline=True)
def power(x, n):
    """x^n of x >= 0 and n >= 0, both finite, as 2^(n log2 x): to (4 + 5 |n log2 x|) 2^-53 of its value.

    Of 0 it is 0, and 1 where n is 0. A power below 2^-1022 is 2^-1022, and one above 2^1023 is 2^1023. It is made of
    what processors do to many numbers at once: sums, products, one division and shifts of bits.
    """
    # The bound, in roundings of 2^-53: s takes 2, its polynomial 1.3, their product and the sum 1 each, all of log2 x,
    # and n another; times ln 2 that is 4.4 |n log2 x|. What is left of y is exact, and 2^r takes 2.3.
    bits = np.float64(np.maximum(x, SMALLEST)).view(np.int64)
    exponent = (bits + BELOW_ONE) >> FRACTION
    m = np.int64(bits - (exponent << FRACTION) + ONE).view(np.float64)
    s = (m - 1.0) / (m + 1.0)
    y = n * (np.int64(exponent | UNITS).view(np.float64) - SHIFTED + s * log2_over_s(s * s))
    y = np.minimum(np.maximum(y, LOWEST), HIGHEST)
    whole = np.floor(y + 0.5)
    scale = np.int64(np.float64(whole + SHIFTED).view(np.int64) << FRACTION).view(np.float64)
    return scale * exp2_within(y - whole) * ((x > 0.0) | (n == 0.0))


# --- the curve, at z = |x| ------------------------------------------------------------------------------------------


@register_jitable
def force(z, k1, b1, ks, a3):
    """Restoring force: the lowest of the three lines, zero beyond a3."""
    return np.maximum(np.minimum(np.minimum(k1 * z, b1), ks * (a3 - z)), 0.0)


@register_jitable
def tangent(z, k1, ks, a1, a2, a3):
    """Slope of the force; at a corner that of the branch further out."""
    return k1 * (z < a1) - ks * ((z >= a2) & (z < a3))


@register_jitable
def double_energy(z, k1, b1, ks, a1, a2, a3):
    """Twice the stored energy 2V(z), V the integral of the force."""
    z1 = np.minimum(z, a1)
    z2 = np.minimum(np.maximum(z, a1), a2)
    z3 = np.minimum(np.maximum(z, a2), a3)
    return k1 * z1 * z1 + 2.0 * b1 * (z2 - a1) + ks * (z3 - a2) * (2.0 * a3 - a2 - z3)


# --- one step of a lane ---------------------------------------------------------------------------------------------


@register_jitable
def newmark_end(v, a, h, p, restoring, c):
    """Explicit Newmark (beta 0, gamma 1/2): velocity and acceleration at the end of a step, its displacement known."""
    half = v + 0.5 * h * a
    a = (p - restoring - c * half) / (1.0 + 0.5 * h * c)
    return half + 0.5 * h * a, a


@register_jitable
def linear_acceleration(v, a, h, dp, k, c):
    """Increments of displacement and velocity by linear acceleration, stiffness and damping frozen over the step."""
    dx = (dp + 6.0 * v / h + 3.0 * a + c * (3.0 * v + 0.5 * h * a)) / (k + 3.0 * c / h + 6.0 / (h * h))
    return dx, 3.0 * dx / h - 3.0 * v - 0.5 * h * a


@register_jitable(fastmath=False)
def product(one, other):
    """A product that is rounded: no sum that it is part of takes it whole, in a vector of lanes or in a lane alone."""
    return one * other


@register_jitable
def impact_within(x, v, a, h):
    """Time from the start of the step to the root of x + v s + a s^2/2, known to lie in (0, h]."""
    away = v if x > 0.0 else -v
    root = np.sqrt(np.maximum(v * v - 2.0 * a * x, 0.0))
    return np.minimum(2.0 * np.abs(x) / np.maximum(root - away, TINY), h)


@register_jitable
def crossed(before, after):
    """Whether a step has reached or passed x = 0. Signs, not the product, which underflows late in a decay."""
    return ((before > 0.0) & (after <= 0.0)) | ((before < 0.0) & (after >= 0.0))


@register_jitable
def odd(x, f):
    """The force f(|x|) with the sign of x."""
    return -f if x < 0.0 else f


@register_jitable
def settle(w, i, x, v, a, step):
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


# --- the dampers: force and coefficient of lane i of a block at z = |x| and the velocity v ---------------------------


@register_jitable
def force_at(w, i, z):
    """Force of lane i of a block."""
    return force(z, w[K1 + i], w[B1 + i], w[KS + i], w[A3 + i])


@register_jitable
def double_energy_at(w, i, z):
    """Twice the stored energy of lane i of a block."""
    return double_energy(z, w[K1 + i], w[B1 + i], w[KS + i], w[A1 + i], w[A2 + i], w[A3 + i])


@register_jitable
def constant_at(w, i, z, v):
    """C is constant: CDC."""
    return force_at(w, i, z), w[C0 + i]


@register_jitable
def root_at(w, i, z, v):
    """C goes with the secant's frequency w, w^2 = f/z: CDR."""
    z = np.maximum(z, TINY)
    f = force_at(w, i, z)
    return f, w[C1 + i] * np.sqrt(f / z)


@register_jitable
def linear_at(w, i, z, v):
    """C goes with the secant's w^2: SDR."""
    z = np.maximum(z, TINY)
    f = force_at(w, i, z)
    return f, w[C2 + i] * (f / z)


@register_jitable(forceinline=True)
def power_at(w, i, z, v):
    """C goes with the secant's w^n: the general exponent."""
    z = np.maximum(z, TINY)
    f = force_at(w, i, z)
    return f, w[C0 + i] * power(f / z, w[HALF_N + i])


@register_jitable
def energy_at(w, i, z, v):
    """C goes with the energy's frequency w, w^2 = f^2/(2V): ECD."""
    z = np.maximum(z, TINY)
    f = force_at(w, i, z)
    return f, w[C1 + i] * np.sqrt(f * f / double_energy_at(w, i, z))


@cache
def energy_of_order_at(order):
    """Return the formula of ECD of a whole order m: C goes with w and the m-th power of the kinetic fraction T/(T + V).

    The power is of multiplications alone. At rest at the origin, where no energy is, the fraction is 0: 2V is not.
    """

    @register_jitable
    def formula(w, i, z, v):
        z = np.maximum(z, TINY)
        f = force_at(w, i, z)
        double_v = double_energy_at(w, i, z)
        double_t = v * v
        fraction = double_t / (double_t + double_v)
        return f, w[C1 + i] * np.sqrt(f * f / double_v) * fraction**order

    formula.__name__ = formula.__qualname__ = f"energy_{order}_at"
    return formula


@register_jitable(forceinline=True)
def energy_of_any_order_at(w, i, z, v):
    """ECD of any order m >= 0, each lane with its own."""
    z = np.maximum(z, TINY)
    f = force_at(w, i, z)
    double_v = double_energy_at(w, i, z)
    double_t = v * v
    fraction = double_t / (double_t + double_v)
    return f, w[C1 + i] * np.sqrt(f * f / double_v) * power(fraction, w[ORDER + i])


@register_jitable
def viscous_at(w, i, z, v):
    """C = c0 + c1 w + c2 w^2 of CDC, CDR, SDR and ECD, w the secant's or where BY_ENERGY is 1 the energy's frequency.

    The scheme as printed is compiled once, by this formula, for the four of them.
    """
    z = np.maximum(z, TINY)
    f = force_at(w, i, z)
    by_energy = w[BY_ENERGY + i]
    by_secant = 1.0 - by_energy
    w2 = f * (by_secant + by_energy * f) / (by_secant * z + by_energy * double_energy_at(w, i, z))
    return f, w[C0 + i] + w[C1 + i] * np.sqrt(w2) + w[C2 + i] * w2


# --- one step of a block of lanes -----------------------------------------------------------------------------------


@register_jitable
def restitution_located(w, width, p0, p1, step):
    """CR, Eq. (8), the impact located inside the step: Newmark up to it, the velocity times e, Newmark after it."""
    for i in range(width):
        x, v, a, h = w[X + i], w[V + i], w[A + i], w[H + i]
        start, end = w[G_BEFORE + i] * p0, w[G + i] * p1
        ahead = x + h * (v + 0.5 * h * a)
        hit = crossed(x, ahead)
        s = impact_within(x, v, a, h) if hit else 0.0
        # At the impact x = 0, so the restoring force vanishes and the acceleration is the load's alone.
        load = start + (end - start) * (s / h)
        v = w[E + i] * (v + 0.5 * s * (a + load)) if hit else v
        a = load if hit else a
        h -= s
        x = (0.0 if hit else x) + product(h, v + 0.5 * h * a)
        f = force_at(w, i, np.abs(x))
        v, a = newmark_end(v, a, h, end, odd(x, f), 0.0)
        settle(w, i, x, v, a, step)


@register_jitable
def restitution_printed(w, width, p0, p1, step):
    """CR as printed: linear acceleration without iteration, the velocity times e at the end of the step."""
    # ASSUME: the acceleration at the end of the step comes from the balance of forces there, not from the increment.
    for i in range(width):
        k = tangent(np.abs(w[X + i]), w[K1 + i], w[KS + i], w[A1 + i], w[A2 + i], w[A3 + i])
        dx, dv = linear_acceleration(w[V + i], w[A + i], w[H + i], w[G + i] * (p1 - p0), k, 0.0)
        x, v = w[X + i] + dx, w[V + i] + dv
        v = w[E + i] * v if crossed(w[X + i], x) else v
        f = force_at(w, i, np.abs(x))
        settle(w, i, x, v, w[G + i] * p1 - odd(x, f), step)


@cache
def viscous_newmark(force_and_coefficient):
    """Return a step of viscous damping by explicit Newmark, of one formula of C and no other.

    C is taken at the displacement at the end of the step and at the velocity v + h a that is expected there.
    """

    @register_jitable
    def advance(w, width, p0, p1, step):
        for i in range(width):
            v, a, h = w[V + i], w[A + i], w[H + i]
            x = w[X + i] + h * (v + 0.5 * h * a)
            f, c = force_and_coefficient(w, i, np.abs(x), v + h * a)
            v, a = newmark_end(v, a, h, w[G + i] * p1, odd(x, f), c)
            settle(w, i, x, v, a, step)

    # Numba names machine code by the qualified name and a counter of the process. Were the name one for every damper,
    # one from the cache and one just compiled could have one name, and the linker would take either for both.
    advance.__name__ = advance.__qualname__ = f"newmark_{force_and_coefficient.__name__}"
    return advance


@cache
def viscous_printed(force_and_coefficient):
    """Return a step as printed: C and the tangent frozen at the step's start, balance restored at its end."""

    @register_jitable
    def advance(w, width, p0, p1, step):
        for i in range(width):
            z = np.abs(w[X + i])
            _, c = force_and_coefficient(w, i, z, w[V + i])
            k = tangent(z, w[K1 + i], w[KS + i], w[A1 + i], w[A2 + i], w[A3 + i])
            dx, dv = linear_acceleration(w[V + i], w[A + i], w[H + i], w[G + i] * (p1 - p0), k, c)
            x, v = w[X + i] + dx, w[V + i] + dv
            f, c = force_and_coefficient(w, i, np.abs(x), v)
            settle(w, i, x, v, w[G + i] * p1 - odd(x, f) - c * v, step)

    advance.__name__ = advance.__qualname__ = f"printed_{force_and_coefficient.__name__}"
    return advance


@register_jitable
def compare_with(w, width, reference, row, step):
    """Add this step's term of Eq. (17)."""
    for i in range(width):
        difference = np.abs(reference[row[i], step]) - np.abs(w[X + i])
        w[ERROR + i] += difference * difference


# --- the loop -------------------------------------------------------------------------------------------------------


@register_jitable
def any_alive(w, width):
    """Whether any lane of a block has not collapsed."""
    alive = 0.0
    for i in range(width):
        alive += w[ALIVE + i]
    return alive > 0.0


def plain_march(advance):
    """Return the loop over blocks and steps for one kind of step, as Python runs it."""

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
        blocks : ndarray, shape (blocks, ROWS * LANES)
            State, observations and parameters, laid out as the constants above say.
        width : int
            Lanes of each block, of `WIDTHS`; the rest of its rows is idle.
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
        checkpoints, error : ndarray, shape (windows,) and (blocks, windows, width)
            Steps at which the running sum of Eq. (17) is stored, ascending, and the sums. A sum is only stored while a
            lane of the block stands; those of a collapsed lane mean nothing.
        every, displacement, velocity : int and ndarray, shape (blocks, width, last//every + 1 or more)
            Histories at each `every`-th step; no blocks, no histories. After a collapse they stay as they were made.
        """
        forced, motions = ground.size > 0, ground.shape[0]
        compare = reference.shape[0] > 0
        store = displacement.shape[0] > 0
        for b in range(blocks.shape[0]):
            w = blocks[b]
            window = 0
            while window < checkpoints.size - 1 and checkpoints[window] < first:
                window += 1
            p1 = ground[0, (first - 1) // substeps] if forced else 0.0
            if store and first == 1:
                for i in range(width):
                    displacement[b, i, 0], velocity[b, i, 0] = w[X + i], w[V + i]
            for step in range(first, last + 1):
                p0 = p1
                if forced:
                    sample, part = divmod(step, substeps)
                    p1 = ground[0, sample]
                    if part > 0:
                        p1 += (ground[0, sample + 1] - p1) * part / substeps
                    if motions > 1:
                        for i in range(width):
                            w[G_BEFORE + i] = w[G + i]
                            w[G + i] = factors[b, 0, i] * p1
                        for motion in range(1, motions):
                            p1 = ground[motion, sample]
                            if part > 0:
                                p1 += (ground[motion, sample + 1] - p1) * part / substeps
                            for i in range(width):
                                w[G + i] += factors[b, motion, i] * p1
                        p0, p1 = 1.0, 1.0
                advance(w, width, p0, p1, step)
                if compare:
                    compare_with(w, width, reference, row[b], step)
                    if step == checkpoints[window]:
                        for i in range(width):
                            error[b, window, i] = w[ERROR + i]
                        window = min(window + 1, checkpoints.size - 1)
                if store and step % every == 0:
                    for i in range(width):
                        if w[ALIVE + i] > 0.0:
                            displacement[b, i, step // every] = w[X + i]
                            velocity[b, i, step // every] = w[V + i]
                if step % PATIENCE == 0 and not any_alive(w, width):
                    break

    # A name, and so a file of its own in numba's cache, for each kind of step: where two processes compile at once, the
    # second to write would otherwise leave its code under the first one's entry.
    march.__name__ = march.__qualname__ = f"march_{advance.__name__}"
    return march


@cache
def march(advance):
    """Return the loop over blocks and steps for one kind of step, which is compiled when it is first called."""
    return checked(njit(cache=True, fastmath=True, error_model="numpy", nogil=True)(plain_march(advance)), SOURCE)


# --- a table of five variables --------------------------------------------------------------------------------------


def plain_cubic_in_five(table, at, found):
    """Read a table at some points: through the four nodes nearest to a point, a cubic in each of five variables.

    SciPy's NdBSpline is as near, its map_coordinates is not, and both take some nine times as long: docs/accuracy.md.

    Parameters
    ----------
    table : ndarray, five-dimensional, at least four nodes in each
    at : ndarray, shape (5, points)
        In nodes, from 0 to the last.
    found : ndarray, shape (points,)
        Filled.
    """
    first = np.empty(5, dtype=np.int64)
    weight = np.empty((5, 4))
    for point in range(found.size):
        for axis in range(5):
            node = min(max(int(at[axis, point]) - 1, 0), table.shape[axis] - 4)
            s = at[axis, point] - node
            first[axis] = node
            weight[axis, 0] = -(s - 1.0) * (s - 2.0) * (s - 3.0) / 6.0
            weight[axis, 1] = s * (s - 2.0) * (s - 3.0) / 2.0
            weight[axis, 2] = -s * (s - 1.0) * (s - 3.0) / 2.0
            weight[axis, 3] = s * (s - 1.0) * (s - 2.0) / 6.0
        i0, i1, i2, i3, i4 = first
        total = 0.0
        for a in range(4):
            of_a = 0.0
            for b in range(4):
                of_b = 0.0
                for c in range(4):
                    of_c = 0.0
                    for d in range(4):
                        if weight[3, d] != 0.0:  # at a node, as at a3 = 1, the others have none
                            row = table[i0 + a, i1 + b, i2 + c, i3 + d]
                            of_d = weight[4, 0] * row[i4] + weight[4, 1] * row[i4 + 1]
                            of_c += weight[3, d] * (of_d + weight[4, 2] * row[i4 + 2] + weight[4, 3] * row[i4 + 3])
                    of_b += weight[2, c] * of_c
                of_a += weight[1, b] * of_b
            total += weight[0, a] * of_a
        found[point] = total


@cache
def cubic_in_five():
    """Return the reader of tables, which is compiled when it is first called."""
    return checked(njit(cache=True, fastmath=True, error_model="numpy", nogil=True)(plain_cubic_in_five), SOURCE)
