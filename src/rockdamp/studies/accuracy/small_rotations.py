"""Rigid rocking with and without small rotations and the mass of slender bodies, 2/3 m, over slenderness."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from rockdamp import plausibility
from rockdamp.arrays import Array
from rockdamp.histories.half_cycles import passes_zero
from rockdamp.mechanics import rigid_bodies
from rockdamp.mechanics.wall import Wall
from rockdamp.progress import track

FEATURES = ("first impact", "peaks", "p")
TOLERANCES = (0.01, 0.05)
SAMPLES = 400  # of a history per unit of tau; its features are found by parabolas between them
REFERENCES = ("slender", "large rotation")
MASSES = ("2/3 m", "at u = 0")  # of small rotations, in the forced case
PULSE = 2.0  # peak of the forced case's load over the strength of the rigid wall
DURATIONS = (0.05, 8.0)  # between which its pulse's is sought, in tau

Part = Callable[[float], float]  # of an equation of motion, by x


def features(times: ArrayLike, displacement: ArrayLike, peaks: int) -> Array:
    """Return the time of the first impact and the sizes of the first `peaks` peaks after it; NaN where there are fewer.

    The times are uniform and begin at the release at rest.
    """
    tau, x = np.asarray(times, dtype=float), np.asarray(displacement, dtype=float)
    values = np.full(1 + peaks, np.nan)
    after = 1 + np.flatnonzero(passes_zero(x))
    if after.size:
        k = after[0]  # the line goes on from before the impact, where the velocity jumps
        values[0] = tau[k - 1] + (tau[k - 1] - tau[k - 2]) * x[k - 1] / (x[k - 2] - x[k - 1])
    for n, (start, stop) in enumerate(pairwise(after[: peaks + 1])):
        size = np.abs(x[start:stop])
        top = int(size.argmax())
        if 0 < top < size.size - 1:
            left, middle, right = size[top - 1 : top + 2]
            values[1 + n] = middle + (right - left) ** 2 / (8 * (2 * middle - left - right))
    return values


def frequency_difference(wall: Wall) -> float:
    """p of the whole mass at u = 0 over that of 2/3 m, less one: the stiffness is the slender limit's for both. [-]"""
    slender = float(wall.mass) / 3  # of the hinge's coordinate; half of 2/3 m, see `rigid_bodies.TwoBodies`
    return float(np.sqrt(slender / rigid_bodies.TwoBodies(wall).inertia(0.0)) - 1)


def differences(wall: Wall, restitution: float, release_amplitude: float, peaks: int) -> Array:
    """Compare the large rotations with the slender limit: relative difference of each of `FEATURES`.

    Of the peaks it is the one of largest size. [-]
    """
    energy = release_amplitude * (2 - release_amplitude)
    kept = np.sqrt(1 - energy * restitution ** (2 * np.arange(peaks + 1)))
    quarters = np.arccosh(1 / kept)  # of the slender limit: times from each peak to u = 0
    end = 1.5 * (quarters[0] + 2 * quarters[1:].sum())  # half as long again, lest slow walls have too few peaks
    times = np.linspace(0.0, end, int(SAMPLES * end) + 1)
    small = features(times, rigid_bodies.slender_decay(times, wall, restitution, release_amplitude), peaks)
    large = features(times, rigid_bodies.large_rotation_decay(times, wall, restitution, release_amplitude), peaks)
    return np.array([*compared(large, small), frequency_difference(wall)])


def forced_difference(wall: Wall, peak: float, whole_mass: bool = False) -> float:
    """Compare the first peak under a half-sine pulse at large rotations with that at small ones, less one. [-]

    Small rotations have 2/3 m, the slender limit, or with `whole_mass` the inertia at u = 0. The pulse is `PULSE` times
    the rigid strength, and as long as brings the wall to `peak` u/u_ins by small rotations. Both begin to move when the
    load reaches the strength. NaN where the two bodies fall.
    """
    bodies, scale, third = rigid_bodies.TwoBodies(wall), float(wall.instability_displacement), float(wall.mass) / 3
    strength = float(wall.rigid_strength) / 2  # u carries half of the mass and of the force

    def slender(duration: float) -> float:
        return _first_peak(lambda x: mass, lambda x: 0.0, lambda x: 1.0 - x, duration)

    mass = bodies.inertia(0.0) / third if whole_mass else 1.0
    needed = brentq(lambda duration: min(slender(duration), 1.0) - peak, *DURATIONS, xtol=1e-10)
    # The load on a body is on its centre, half way between its two corners that touch: it moves by u/2 exactly.
    large = _first_peak(
        lambda x: bodies.inertia(x * scale) / third,
        lambda x: bodies.inertia_slope(x * scale) * scale / third,
        lambda x: bodies.potential_slope(x * scale) / strength,
        needed,
    )
    return large / peak - 1 if np.isfinite(large) else np.nan


def _first_peak(inertia: Part, slope: Part, pull: Part, duration: float) -> float:
    """Return the first peak of M x'' + M' x'^2/2 + U' = load from rest; infinite where the wall collapses. [-]"""
    tau, state = duration * np.arcsin(1 / PULSE) / np.pi, (0.0, 0.0)

    def rates(t: float, y: Array) -> tuple[float, float]:
        load = PULSE * np.sin(np.pi * t / duration) if t < duration else 0.0
        return y[1], (load - pull(y[0]) - slope(y[0]) * y[1] ** 2 / 2) / inertia(y[0])

    def turns(t: float, y: Array) -> float:
        return y[1] if t > tau + 1e-6 else 1.0

    def falls(_: float, y: Array) -> float:
        return y[0] - 1.0

    turns.terminal, turns.direction = True, -1.0  # type: ignore[attr-defined]
    falls.terminal, falls.direction = True, 1.0  # type: ignore[attr-defined]
    for end in (duration, duration + 50.0):
        run = solve_ivp(rates, (tau, end), state, method="DOP853", events=(turns, falls), rtol=1e-10, atol=1e-12)
        if run.t_events[1].size:
            return np.inf
        if run.t_events[0].size:
            return float(run.y_events[0][0][0])
        tau, state = end, (float(run.y[0, -1]), float(run.y[1, -1]))
    return np.inf


def compared(own: Array, reference: Array) -> tuple[float, float]:
    """Relative differences of the first impact's time, and of the peak that differs most. [-]"""
    ratio = own / reference - 1
    return float(ratio[0]), float(ratio[1:][np.nanargmax(np.abs(ratio[1:]))])


def least_slenderness(slenderness: ArrayLike, difference: ArrayLike, tolerance: float) -> float:
    """Slenderness beyond which |difference| stays within `tolerance`, by power laws between the values. [-]

    NaN where the last value is not within it; the first value where all are.
    """
    h, d = np.asarray(slenderness, dtype=float), np.abs(np.asarray(difference, dtype=float))
    beyond = np.flatnonzero(~(d <= tolerance))
    if not beyond.size:
        return float(h[0])
    last = beyond[-1]
    if last == h.size - 1:
        return float("nan")
    pair = slice(last, last + 2)
    # np.interp wants ascending abscissae, and the difference falls.
    return float(np.exp(np.interp(np.log(tolerance), np.log(d[pair])[::-1], np.log(h[pair])[::-1])))


def rotations(
    loops: xr.Dataset,
    fig4_wall: Wall,
    *,
    restitution: float,
    slenderness: ArrayLike,
    hinge_ratio: ArrayLike,
    release_amplitude: ArrayLike,
    peaks: int,
) -> xr.Dataset:
    """Compare rigid rocking with and without small rotations, for all combinations of h/t, h1/h and u0/u_ins.

    The walls are as thick as that of Fig. 4a, which is compared too. So many peaks after the release are compared.
    """
    axes = [np.unique(np.asarray(axis, dtype=float)) for axis in (hinge_ratio, release_amplitude, slenderness)]
    shape, thickness = [axis.size for axis in axes], float(fig4_wall.thickness)
    difference, forced = np.empty((len(FEATURES), *shape)), np.empty((len(MASSES), *shape))
    for index in track(list(np.ndindex(*shape)), "rotations"):
        r, x0, ratio = (axis[i] for axis, i in zip(axes, index, strict=True))
        with plausibility.as_meant():  # only the shape matters, and the most slender are higher than any wall
            wall = Wall(thickness, ratio * thickness, hinge_ratio=r)
        difference[:, *index] = differences(wall, restitution, x0, peaks)
        forced[:, *index] = [forced_difference(wall, x0, whole_mass) for whole_mass in (False, True)]
    least = [
        [least_slenderness(axes[2], row, tolerance) for tolerance in TOLERANCES]
        for row in difference.reshape(-1, axes[2].size)
    ]
    dims = ("rocking_feature", "hinge_ratio", "rocking_release_amplitude")
    return xr.Dataset(
        {
            "rocking_difference": ((*dims, "slenderness"), difference),
            "forced_difference": (("forced_mass", *dims[1:], "slenderness"), forced),
            "least_slenderness": ((*dims, "tolerance"), np.reshape(least, (*difference.shape[:-1], len(TOLERANCES)))),
            "fig4_difference": (("rocking_reference", "rocking_feature"), _fig4(loops, fig4_wall, peaks)),
        },
        coords={
            "rocking_feature": list(FEATURES),
            "rocking_reference": list(REFERENCES),
            "forced_mass": list(MASSES),
            "hinge_ratio": axes[0],
            "rocking_release_amplitude": axes[1],
            "slenderness": axes[2],
            "tolerance": list(TOLERANCES),
            "rocking_restitution": restitution,
        },
    )


def _fig4(loops: xr.Dataset, wall: Wall, peaks: int) -> Array:
    """Differences of Fig. 4a's tri-linear wall, whose mass is 2/3 m, from each reference."""
    tau = loops["tau"].values
    each = {
        str(name): features(tau, loops["rocking_displacement"].sel(rocking_model=name).values, peaks)
        for name in loops["rocking_model"].values
    }
    of_p = {"slender": 0.0, "large rotation": 1 / (1 + frequency_difference(wall)) - 1}
    return np.array([[*compared(each["tri-linear"], each[name]), of_p[name]] for name in REFERENCES])
