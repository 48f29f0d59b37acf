"""Dependence of the equivalent damping ratio on the amplitude, for each damper, by three measures of equivalence.

Peaks: over the half cycle after the release the damper loses exactly what an impact takes, V(x1) = e^2 V(x0).
Err: Eq. (17). Closed form: first order in the loss; and with the energy in the middle of the half cycle, second order
(docs/theory.md derives both). The exponent n whose closed form depends least on the amplitude comes with them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike
from scipy.optimize import elementwise

from rockdamp.arrays import Array
from rockdamp.config import Config
from rockdamp.config.sections import AmplitudeDependence, CurveMap
from rockdamp.config.study import PlateauBeyond
from rockdamp.equivalence.closed_form import damping_ratio_energy, damping_ratio_middle, equivalence_factor
from rockdamp.errors import InputError
from rockdamp.histories.half_cycles import turns
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.progress import track
from rockdamp.solvers.newmark import solve
from rockdamp.studies.matches import match_decays
from rockdamp.vocabulary import PAPER_MODELS, PRESETS, SOFTENING, VISCOUS_MODELS

BEST = "POWER"  # the general exponent, at the best n of each curve
DAMPERS = (*PAPER_MODELS, BEST, *(model for model in VISCOUS_MODELS if model not in PAPER_MODELS))
EXPONENTS_TRIED = (0.8, 1.3, 2.0)  # where the search for the best one starts
PARAMETERS = ("yield_displacement_ratio", "strength_ratio", "ultimate_displacement_ratio")
SOURCES = {"error": "damping_ratio", "peaks": "damping_ratio_peaks", "energy": "damping_ratio_energy"}
ROOM = 1e-9  # a plateau shorter than this is none
HALF_CYCLE_STEPS = 5000  # the damping ratio of ECD from peaks, whose exact value is known, is then within 0.04 %
LONGER = 1.7  # bounds what a half cycle lasts under damping, over its undamped duration
BRACKET = (0.25, 4.0)  # of the damping ratio from peaks, over the closed form's
TOLERANCES = {"xrtol": 1e-9, "fatol": 1e-12}


@dataclass(frozen=True)
class Group:
    """Curves with one variant of the last branch, of shape (cases,), and their names."""

    name: list[str]
    curve: TrilinearCurve


def groups(asked: AmplitudeDependence, strength_ratio: float, beyond: PlateauBeyond) -> list[Group]:
    """Return the curves of the study: steeper (and, for a3 = 1, without a variant), then translated.

    They are b1 of the study `cracked_stiffness` at the a1 of the settings, and Doherty's presets. All have
    a3 = 1, and the settings' a3 in both variants, the translated one where it leaves room for a plateau.
    """
    a1s = asked.yield_displacement_ratio
    plateaus = beyond.at(a1s, strength_ratio)
    shapes = [(f"a1 = {a1:g}", a1, b1) for a1, b1 in zip(a1s, plateaus, strict=True)]
    shapes += [(name, a1, b1) for name, (b1, a1) in PRESETS.items()]
    a3 = asked.ultimate_displacement_ratio
    steeper = [(*shape, 1.0) for shape in shapes] + [(*shape, a3) for shape in shapes]
    translated = [(*shape, a3) for shape in shapes if shape[1] + shape[2] < a3]
    return [
        _group(cases, softening) for cases, softening in zip((steeper, translated), SOFTENING, strict=True) if cases
    ]


def _group(cases: list[tuple[str, float, float, float]], softening: str) -> Group:
    names, *parameters = zip(*cases, strict=True)
    a1, b1, a3 = (np.array(values, dtype=float) for values in parameters)
    curve = TrilinearCurve(a1, b1, a3, softening)
    return Group([name if end == 1 else f"{name}, {softening}" for name, end in zip(names, a3, strict=True)], curve)


def amplitude_dependence(config: Config) -> xr.Dataset:
    """Compare the damping ratios from peaks, from Err and from the closed form, and find the best exponents."""
    curves = groups(
        config.amplitude_dependence, config.curve.strength_ratio, config.studies.cracked_stiffness.strength_ratio_beyond
    )
    parts = [_measured(group, config) for group in curves]
    dataset = xr.concat(parts, "case", join="exact", combine_attrs="drop", data_vars="minimal", coords="minimal")
    best = exponent_map(
        config.amplitude_dependence.map,
        config.amplitude_dependence.release_share,
        config.amplitude_dependence.ultimate_displacement_ratio,
    )
    return dataset.merge(best).assign_coords(response_length=config.matching.response_length)


def _measured(group: Group, config: Config) -> xr.Dataset:
    """Return all measures for the curves of a group."""
    share, restitution = config.amplitude_dependence.release_share, config.amplitude_dependence.restitution
    shape = (len(group.name), share.size, restitution.size)
    exponent = best_exponent(group.curve.map(lambda p: p[:, None]), share)
    case, share_at, e_at = (index.ravel() for index in np.indices(shape))
    curve, n = group.curve.map(lambda p: p[case]), exponent[case]
    ultimate = np.asarray(group.curve.ultimate_displacement_ratio)
    amplitude, e = share[share_at] * ultimate[case], restitution[e_at]
    matched = match_decays(
        curve,
        amplitude,
        e,
        DAMPERS,
        config.matching.model_copy(update={"refinement": config.amplitude_dependence.refinement}),
        step=config.solver.step,
        scheme=config.solver.scheme,
        exponent=n,
        description=f"amplitude dependence, {len(group.name)} curves",
    )
    measures = {
        "damping_ratio": [of.damping_ratio for of in matched.values()],
        "damping_ratio_uncertainty": [of.uncertainty for of in matched.values()],
        "damping_ratio_peaks": [damping_ratio_peaks(curve, model, e, amplitude, n) for model in DAMPERS],
        "damping_ratio_energy": [damping_ratio_energy(curve, model, e, amplitude, n) for model in DAMPERS],
        "damping_ratio_middle": [damping_ratio_middle(curve, model, e, amplitude, n) for model in DAMPERS],
    }
    dims = ("damping_model", "case", "release_share", "restitution")
    dataset = xr.Dataset(
        {key: (dims, np.reshape(values, (len(DAMPERS), *shape))) for key, values in measures.items()},
        coords={
            "damping_model": list(DAMPERS),
            "case": group.name,
            "release_share": share,
            "restitution": restitution,
            **{name: ("case", np.asarray(getattr(group.curve, name))) for name in PARAMETERS},
            "softening": ("case", [group.curve.softening if a3 < 1 else "none" for a3 in ultimate]),
            "release_amplitude": (("case", "release_share"), share * ultimate[:, None]),
        },
    )
    dataset["best_exponent"] = ("case", exponent)
    for source, key in SOURCES.items():
        dataset[f"spread_{source}"] = xr.apply_ufunc(np.log, dataset[key]).std("release_share")
    return dataset


# --- peaks -----------------------------------------------------------------------------------------------------------


def damping_ratio_peaks(
    curve: TrilinearCurve,
    damping_model: str,
    restitution: ArrayLike,
    release_amplitude: ArrayLike,
    exponent: ArrayLike = 0.0,
) -> Array:
    """Return the damping ratio with which the half cycle after a release ends at CR's peak, V(x1) = e^2 V(x0). [-]

    All arguments broadcast; the exponent is that of ``"POWER"``. It raises `InputError` where a ratio lies outside
    `BRACKET` times the closed form's.
    """
    guess = damping_ratio_energy(curve, damping_model, restitution, release_amplitude, exponent)
    shape = guess.shape

    def flat(value: ArrayLike) -> Array:
        return np.broadcast_to(np.asarray(value, dtype=float), shape).ravel()

    curves = curve.map(flat)
    delta, x0, n = -np.log(flat(restitution)), flat(release_amplitude), flat(exponent)

    def excess(xi: Array, at: Array) -> Array:
        case = at.astype(np.int64)
        some = curves.map(lambda p: p[case])
        return (
            decrement(some, Damping.from_values(damping_model, damping_ratio=xi, exponent=n[case]), x0[case])
            - delta[case]
        )

    low, high = (factor * guess.ravel() for factor in BRACKET)
    root = elementwise.find_root(excess, (low, high), args=(np.arange(x0.size, dtype=float),), tolerances=TOLERANCES)
    if not root.success.all():
        bad = int(np.flatnonzero(~root.success)[0])
        raise InputError(
            f"the damping ratio of {damping_model} from the first peak at u0/u_ins = {x0[bad]:.6g} and"
            f" e = {np.exp(-delta[bad]):.6g} is not within {BRACKET} times the closed form's, {guess.ravel()[bad]:.6g}"
        )
    return root.x.reshape(shape)


def decrement(curve: TrilinearCurve, damping: Damping, release_amplitude: Array) -> Array:
    """ln sqrt(V(x0)/V(x1)) over the half cycle that begins at rest at x0; each argument of shape (lanes,). [-]"""
    step = LONGER * curve.period(release_amplitude) / 2 / HALF_CYCLE_STEPS
    response = solve(
        curve, damping, release_amplitude=release_amplitude, step=step, steps=HALF_CYCLE_STEPS, store_every=1
    )
    turned, _ = turns(response.displacement, response.velocity, step)
    if not turned.shape[1] or np.isnan(turned[:, 0]).any():
        raise InputError(f"a half cycle under {damping.model} lasts more than {LONGER} times an undamped one")
    return 0.5 * np.log(curve.energy(release_amplitude) / curve.energy(turned[:, 0]))


# --- the exponent ----------------------------------------------------------------------------------------------------


def spread(curve: TrilinearCurve, damping: Damping, share: Array) -> Array:
    """Standard deviation over the amplitudes, the last axis, of the logarithm of the closed form's factor g. [-]

    The curve has the shape (..., 1), the shares u0/u3 (amplitudes,).
    """
    factor = equivalence_factor(curve, damping, share * np.asarray(curve.ultimate_displacement_ratio))
    return np.log(factor).std(axis=-1)


def best_exponent(curve: TrilinearCurve, share: Array) -> Array:
    """Return the exponent n with the least `spread`, for curves of shape (cases, 1). [-]"""
    count = int(np.prod(curve.shape))
    curves = curve.map(lambda p: p.reshape(-1, 1))

    def of_exponent(n: Array, at: Array) -> Array:
        case = at.astype(np.int64)
        return spread(curves.map(lambda p: p[case]), Damping.power(n[:, None], 1.0), share)

    low, middle, high = (np.full(count, n) for n in EXPONENTS_TRIED)
    args = (np.arange(count, dtype=float),)
    bracket = elementwise.bracket_minimum(of_exponent, middle, xl0=low, xr0=high, xmin=0.0, args=args)
    minimum = elementwise.find_minimum(of_exponent, bracket.bracket, args=args, tolerances={"xrtol": 1e-6})
    if not (bracket.success & minimum.success).all():
        bad = int(np.flatnonzero(~(bracket.success & minimum.success))[0])
        raise InputError(f"no exponent n depends least on the amplitude on the curve {curves.map(lambda p: p[bad])}")
    return minimum.x


def exponent_map(curves: CurveMap, share: Array, ultimate_displacement_ratio: float) -> xr.Dataset:
    """Best exponent and spreads of the closed form over a1 and b1, without and with both variants of the last branch.

    NaN where a1 and b1 leave no room for the plateau or for the variant.
    """
    a1, b1 = curves.yield_displacement_ratio, curves.strength_ratio
    variants = ("none", *SOFTENING)
    shape = (len(variants), b1.size, a1.size)
    best, spreads = np.full(shape, np.nan), np.full((len(DAMPERS), *shape), np.nan)
    for index, variant in enumerate(track(variants, "exponents")):
        a3 = 1.0 if variant == "none" else ultimate_displacement_ratio
        translated = variant == "translated"
        b, a = (grid.ravel() for grid in np.meshgrid(b1, a1, indexing="ij"))
        room = a + b < (a3 if translated else 1.0) - ROOM
        curve = TrilinearCurve(a[room][:, None], b[room][:, None], a3, variant if variant in SOFTENING else "steeper")
        n = best_exponent(curve, share)
        best[index].reshape(-1)[room] = n
        for row, model in enumerate(DAMPERS):
            damping = Damping.from_values(model, damping_ratio=1.0, exponent=n[:, None])
            spreads[row, index].reshape(-1)[room] = spread(curve, damping, share)
    dims = ("map_softening", "map_strength_ratio", "map_yield_displacement_ratio")
    return xr.Dataset(
        {"map_best_exponent": (dims, best), "map_spread": (("damping_model", *dims), spreads)},
        coords={
            "damping_model": list(DAMPERS),
            dims[0]: list(variants),
            dims[1]: b1,
            dims[2]: a1,
        },
    )
