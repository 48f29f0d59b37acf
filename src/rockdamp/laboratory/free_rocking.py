"""A wall identified by free-rocking tests: its curve by half periods, e by the energies of peaks, and which damper."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import xarray as xr
from scipy.special import ndtri
from scipy.stats import chi2

from rockdamp.arrays import Array
from rockdamp.constants import MODELS, REFERENCE, SOFTENING
from rockdamp.equivalence.closed_form import equivalence_factor
from rockdamp.errors import InputError, check, check_choice
from rockdamp.histories.respond import record_attributes
from rockdamp.laboratory.calibration import true_values
from rockdamp.laboratory.excursions import LEVEL, Excursions, Losses, Solution, exponent_of, restitution_at
from rockdamp.laboratory.releases import FreeRocking, Release, releases_of, rest_deviation
from rockdamp.laboratory.uncertainty import check_deviations
from rockdamp.mechanics.curve import RULES, TrilinearCurve
from rockdamp.mechanics.damping import DAMPERS, Damping
from rockdamp.mechanics.wall import Parapet, Wall

PARAMETERS = ("yield_displacement_ratio", "strength_ratio", "restitution")
FEWEST_IMPACTS = 3  # from beyond u1
NORMAL = round(float(ndtri(0.5 + LEVEL / 2)), 4)  # quantile of the normal distribution
WIDEST = 10.0  # half of an interval of ln e: a peak in the noise leaves none that is narrower
DIFFERENCE = 1e-5
AMPLITUDES, HANDED_ON = (0.1, 0.3, 0.5), 0.3  # of u_ins, where e is told; where an assessment takes it from


def fit_free_rocking(
    tests: FreeRocking | Sequence[FreeRocking],
    wall: Wall | Parapet,
    *,
    ultimate_displacement_ratio: float = 1.0,
    softening: str = "steeper",
    least_peak: float | None = None,
    uncertain: Mapping[str, float] | None = None,
) -> xr.Dataset:
    r"""Fit a1, b1 and e to free-rocking tests of one specimen, and the exponent g of its losses.

    Between impacts the wall moves freely, in closed form. Least squares fit this motion to each whole decay, with an
    amplitude for each half cycle, a1, b1, and the sensor's zero and drift. The energies of two peaks give the loss of
    the impact between them, ``-ln e``; half periods give a1 and b1. Then the losses of all impacts are averaged.

    Intervals hold 90 %. They include the sensor's noise, zero and drift, and that of the mean e the scatter from impact
    to impact, which is estimated; and the sizes of the wall that are `uncertain`. They do not include an error of the
    sensor's gain.

    Parameters
    ----------
    tests : FreeRocking or sequence of them
        Each with one or more releases.
    wall : Wall or Parapet
        Its geometry and weights are taken as known but for those that are `uncertain`: they give u_ins and p.
    ultimate_displacement_ratio, softening : float and str
        a3 and the variant of softening, taken as known.
    least_peak : float, optional
        Smallest peak that is used; by default ten standard deviations of the sensor's noise. [m]
    uncertain : dict of float, optional
        Standard deviations of those sizes of the wall that are not exact, by name, such as ``{"thickness": 0.002}``.

    Returns
    -------
    xarray.Dataset
        ``estimate``, ``standard_error`` and ``interval`` (parameter); ``impact_restitution`` with its interval
        (impact); peaks and half periods (half_cycle); ``loss_exponent`` g with its interval, and how well each
        damper explains the losses (damping_model); the measured and the fitted displacement (sample).

    Raises
    ------
    InputError
        If there are too few peaks, the specimen rocks to one side only, peaks lie beyond u_ins, or b1 lies at a bound
        of the search.

    Examples
    --------
    >>> import numpy as np
    >>> import rockdamp as rd
    >>> wall = rd.Wall(thickness=0.25, height=3.0)
    >>> curve, damping = rd.TrilinearCurve(0.05, 0.80), rd.Damping("CR", 0.88)
    >>> p = float(wall.frequency_parameter)
    >>> decay = rd.free_decay(curve, damping, wall=wall, length=6.0 * p, step=0.002 * p)
    >>> held = np.full(200, 0.125)
    >>> shown = np.concatenate([held, decay.control_displacement]) + 1e-4 * np.random.RandomState(1).standard_normal(
    ...     3201
    ... )
    >>> test = rd.FreeRocking(0.002 * np.arange(3201), shown)
    >>> fitted = rd.fit_free_rocking(test, wall)
    >>> fitted.estimate.values.round(3)
    array([0.05, 0.8 , 0.88])
    """
    valid, allowed = RULES["ultimate_displacement_ratio"]
    a3 = float(check("ultimate_displacement_ratio", ultimate_displacement_ratio, valid, allowed))
    check_choice("softening", softening, SOFTENING)
    given = [tests] if isinstance(tests, FreeRocking) else list(tests)
    _require_unlike(given)
    if least_peak is not None:
        check("least_peak", least_peak, lambda peak: peak > 0, "greater than 0 [m]")
    deviations = check_deviations(wall, uncertain)

    def solution_of(mechanism: Wall | Parapet) -> Solution:
        return _solution(given, mechanism, a3, softening, least_peak)

    fitted = _summary(solution_of(wall), given[0])
    if deviations:
        fitted = _widened(fitted, _by_sizes(wall, deviations, lambda other: _summary(solution_of(other), given[0])))
    resting = [rest_deviation(displacement_of(test, wall)) for test in given]
    fitted = fitted.assign(
        rest_deviation=np.nanmean(resting) if np.isfinite(resting).any() else np.nan,
        restitution_rigid=float(wall.restitution_rigid),
        restitution_impulsive=float(wall.restitution_impulsive),
        instability_displacement=float(wall.instability_displacement),
        frequency_parameter=float(wall.frequency_parameter),
    )
    synthetic = "yes" if any(test.synthetic for test in given) else "no"
    fitted.attrs = record_attributes(given[0].header) | {"record_synthetic": synthetic}
    return fitted


def _require_unlike(tests: Sequence[FreeRocking]) -> None:
    """Refuse a test that is given twice: it would count twice, and the errors come out too small."""
    first: dict[bytes, int] = {}
    for place, test in enumerate(tests, start=1):
        same = first.setdefault(test.measured.tobytes(), place)
        if same != place:
            raise InputError(f"tests {same} and {place} have the same displacements; each must be given once")


def _solution(
    tests: Sequence[FreeRocking], wall: Wall | Parapet, a3: float, softening: str, least_peak: float | None
) -> Solution:
    """Return the least squares of all releases of the tests."""
    p, u_ins = float(wall.frequency_parameter), float(wall.instability_displacement)
    releases: list[Release] = []
    for test in tests:
        releases += releases_of(test, displacement_of(test, wall), least_peak)
        _check_size(test, releases[-1], a3 * u_ins, wall)
    solution = Excursions(releases, p, u_ins, a3, softening).solution()
    solution.check_inside()
    return solution


def _by_sizes(
    wall: Wall | Parapet, deviations: Mapping[str, float], fit: Callable[[Wall | Parapet], xr.Dataset]
) -> Array:
    """Return the variance that uncertain sizes of the wall give a1, b1 and e, by fits with other sizes."""
    variance = np.zeros(len(PARAMETERS))
    for name, deviation in deviations.items():
        other: list[Any] = [{name: float(getattr(wall, name)) + side * deviation} for side in (1, -1)]
        high, low = (fit(replace(wall, **changed))["estimate"].values for changed in other)
        variance += ((high - low) / 2) ** 2
    return variance


def _widened(fitted: xr.Dataset, variance: Array) -> xr.Dataset:
    """Add a variance to those of the parameters, and to their intervals."""
    estimate = fitted["estimate"].values
    reach = np.sqrt((fitted["interval"].values - estimate) ** 2 + NORMAL**2 * variance)
    interval = estimate + np.array([[-1.0], [1.0]]) * reach
    return fitted.assign(
        standard_error=("parameter", np.sqrt(fitted["standard_error"].values ** 2 + variance)),
        interval=(("bound", "parameter"), np.maximum(interval, 0.0)),
    )


def displacement_of(test: FreeRocking, wall: Wall | Parapet) -> Array:
    """Return the displacement at the hinge, or at the top of a parapet; rotations are taken as small. [m]"""
    if test.displacement is not None:
        return test.displacement
    # ASSUME: a rotation is that of the lower body, or of the parapet.
    return np.asarray(test.rotation) * lever(wall)


def lever(wall: Wall | Parapet) -> float:
    """Return the displacement of a unit rotation: the height of the hinge, or of a parapet. [m]"""
    return float(wall.lower_height if isinstance(wall, Wall) else wall.height)


def _check_size(test: FreeRocking, release: Release, u3: float, wall: Wall | Parapet) -> None:
    """Raise `InputError` for a peak beyond which the wall collapses."""
    peak = float(np.abs(release.peaks).max())
    if peak < u3:
        return
    shown, most = (
        (f"{peak:.4g} m", f"{u3:.4g} m at the hinge or top")
        if test.rotation is None
        else (f"{peak / lever(wall):.4g} rad", f"{u3 / lever(wall):.4g} rad")
    )
    raise InputError(f"the largest peak is {shown}; it must be less than {most}, where the wall collapses")


def _summary(solution: Solution, first: FreeRocking) -> xr.Dataset:
    test, curve = solution.test, solution.curve
    values, covariance = _derived(solution)
    amplitudes = [np.exp(solution.point[part][3:]) for part in test.slices]
    before = np.concatenate([amplitude[:-1] for amplitude in amplitudes])
    release_of_impact = np.repeat(np.arange(len(amplitudes)), [amplitude.size - 1 for amplitude in amplitudes])
    # ASSUME: below u1 a wall vibrates on its first branch and does not rock: what it loses there is not restitution.
    rocking = before > values[0]
    if np.count_nonzero(rocking) < FEWEST_IMPACTS:
        impacts = f"{np.count_nonzero(rocking)} impacts follow a peak beyond u1"
        raise InputError(f"{impacts}; there must be at least {FEWEST_IMPACTS}: release it from further out")
    losses = Losses(values[2:], covariance[2:, 2:]).of(rocking)
    mean = losses.line(np.ones(losses.decrement.size))
    e = float(np.exp(-mean.decrement))
    errors = np.sqrt(np.diag(covariance))
    reach = min(losses.quantile * mean.standard_error, WIDEST)
    estimate = np.array([*values[:2], e])
    low = np.array([*(values[:2] - NORMAL * errors[:2]), float(np.exp(-mean.decrement - reach))])
    high = np.array([*(values[:2] + NORMAL * errors[:2]), float(np.exp(-mean.decrement + reach))])
    each, each_error = np.exp(-values[2:]), np.minimum(NORMAL * errors[2:], WIDEST)
    return xr.Dataset(
        {
            "estimate": ("parameter", estimate),
            "standard_error": ("parameter", np.array([*errors[:2], e * mean.standard_error])),
            "interval": (("bound", "parameter"), np.stack([np.maximum(low, 0.0), high])),
            "true_value": ("parameter", true_values(first.header, PARAMETERS)),
            "impact_restitution": ("impact", each),
            "impact_restitution_interval": (("bound", "impact"), each * np.exp([-each_error, each_error])),
            "impact_amplitude": ("impact", before),
            "impact_rocking": ("impact", rocking.astype(int)),
            "restitution_scatter": mean.scatter,
            "restitution_unlike_releases": _between(losses, release_of_impact[rocking]),
            **_exponents(losses, curve, before[rocking], e, rocking),
            **_at_amplitudes(losses, curve, before[rocking]),
            **_histories(solution, amplitudes),
        },
        coords={
            "parameter": list(PARAMETERS),
            "bound": ["low", "high"],
            "damping_model": list(MODELS),
            "release": np.arange(1, len(test.releases) + 1),
            "impact": np.arange(1, before.size + 1),
            "amplitude": list(AMPLITUDES),
        },
    )


def _derived(solution: Solution) -> tuple[Array, Array]:
    """Return a1, b1 and the losses of all impacts, and their covariance by the sensor."""
    test = solution.test

    def derived(points: Array) -> Array:
        curve = test.curve(points[:, 0, None], points[:, 1, None])
        losses = []
        for part in test.slices:
            energy = curve.energy(np.exp(points[:, part][:, 3:]))
            losses.append(0.5 * np.log(energy[:, :-1] / energy[:, 1:]))
        a1b1 = [np.broadcast_to(curve.yield_displacement_ratio, (len(points), 1)), points[:, 1:2]]
        return np.concatenate([*a1b1, *losses], axis=1)

    h = DIFFERENCE * np.eye(solution.point.size)
    sides = derived(np.concatenate([solution.point + h, solution.point - h]))
    gradient = ((sides[: len(h)] - sides[len(h) :]) / (2 * DIFFERENCE)).T
    return derived(solution.point[None])[0], gradient @ solution.covariance @ gradient.T


def _exponents(losses: Losses, curve: TrilinearCurve, before: Array, e: float, rocking: Array) -> dict[str, object]:
    """Return g of the law of loss, and what each damper would show on this curve."""
    log_energy = np.log(curve.energy(before))
    middle = curve.amplitude(e * curve.energy(before))  # of a half cycle: a damper's loss there is that of second order
    exponent, interval = exponent_of(losses, log_energy)
    likelihoods, expected = [], []
    restitution = np.full((len(MODELS), rocking.size), np.nan)
    for index, model in enumerate(MODELS):
        shape = np.ones(before.size)
        if model != REFERENCE and not DAMPERS[model].is_amplitude_independent:
            shape = 1 / equivalence_factor(curve, Damping(model, 1.0), middle)
        line = losses.line(shape / shape.mean(), restricted=False)
        expected.append(-float(np.polyfit(log_energy, np.log(shape), 1)[0]))
        likelihoods.append(line.log_likelihood)
        restitution[index, rocking] = np.exp(-line.decrement * shape / shape.mean())
    return {
        "loss_exponent": exponent,
        "loss_exponent_interval": ("bound", np.array(interval)),
        "expected_exponent": ("damping_model", np.array(expected)),
        "expected_restitution": (("damping_model", "impact"), restitution),
        "relative_log_likelihood": ("damping_model", np.array(likelihoods) - max(likelihoods)),
        "log_likelihood_threshold": -losses.threshold,
    }


def _at_amplitudes(losses: Losses, curve: TrilinearCurve, before: Array) -> dict[str, object]:
    """Return e at `AMPLITUDES`, by the law of loss by amplitude."""
    at = np.log(curve.energy(np.array(AMPLITUDES)))
    found = [restitution_at(losses, np.log(curve.energy(before)), float(one)) for one in at]
    return {
        "restitution_at_amplitude": ("amplitude", np.array([e for e, _ in found])),
        "restitution_at_amplitude_interval": (("bound", "amplitude"), np.array([ends for _, ends in found]).T),
    }


def _histories(solution: Solution, amplitudes: Sequence[Array]) -> dict[str, object]:
    """Return releases, half cycles and samples, each one release after the other."""
    test, curve = solution.test, solution.curve
    parts: dict[str, list[Array]] = {}

    def put(**values: Array) -> None:
        for name, value in values.items():
            parts.setdefault(name, []).append(np.atleast_1d(value))

    for index, (release, part) in enumerate(zip(test.releases, test.slices, strict=True)):
        own, amplitude, start = solution.point[part], amplitudes[index], release.elapsed[0]
        quarter = curve.period(amplitude) / (4 * test.p)
        crossing = start + own[0] / test.p + np.concatenate([[0.0], np.cumsum(2 * quarter[1:-1])])
        peak = np.concatenate([[crossing[0] - quarter[0]], crossing + quarter[1:]])
        trend = own[1] + own[2] * ((release.elapsed - start) / (release.elapsed[-1] - start) - 0.5)
        computed = test.computed(solution.point[None], index)[0] - trend
        side = np.sign(release.peaks)
        put(
            release_elapsed=peak[0],
            release_displacement=test.u_ins * side[0] * amplitude[0],
            sensor_zero=release.zero + test.u_ins * own[1],
            sensor_drift=test.u_ins * own[2] / (release.elapsed[-1] - start),
            half_cycle_release=np.full(amplitude.size, index + 1),
            peak_elapsed=peak,
            peak_displacement=test.u_ins * side * amplitude,
            half_period=np.concatenate([[np.nan], release.half_periods, [np.nan]]),
            half_period_fitted=2 * quarter,
            impact_release=np.full(crossing.size, index + 1),
            impact_elapsed=crossing,
            sample_release=np.full(release.elapsed.size, index + 1),
            sample_elapsed=release.elapsed,
            measured=test.u_ins * (test.measured[index] - trend),
            control_displacement=test.u_ins * computed,
        )
    of_half_cycles = ("peak_elapsed", "peak_displacement", "half_period", "half_period_fitted")
    dims = dict.fromkeys(of_half_cycles, "half_cycle")
    residual = test.u_ins * solution.residual
    return {
        **{name: (dims.get(name) or _dim(name), np.concatenate(values)) for name, values in parts.items()},
        "residual_rms": float(np.sqrt(residual @ residual / (residual.size - solution.point.size))),
    }


def _dim(name: str) -> str:
    prefixes = ("half_cycle", "impact", "sample", "release", "sensor")
    kind = next((prefix for prefix in prefixes if name.startswith(prefix)), "sample")
    return "release" if kind == "sensor" else kind


def _between(losses: Losses, release: Array) -> float:
    """Return the probability of mean losses that differ between the releases at least so much, NaN for one release."""
    groups = [release == number for number in np.unique(release)]
    if len(groups) < 2:
        return np.nan
    scatter = losses.line(np.ones(losses.decrement.size)).scatter
    lines = []
    for group in groups:
        part = losses.of(group)
        weights = np.linalg.inv(part.covariance + scatter**2 * np.eye(part.decrement.size)).sum(axis=0)
        lines.append((float(weights @ part.decrement / weights.sum()), float(weights.sum())))
    means, precisions = np.array(lines).T
    pooled = float(means @ precisions / precisions.sum())
    return float(chi2.sf(((means - pooled) ** 2) @ precisions, len(groups) - 1))
