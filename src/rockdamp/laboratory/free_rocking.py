"""Free-rocking tests: the curve by half periods, e by the energies of peaks, and how likely each damper is."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import xarray as xr
from scipy.stats import t as student

from rockdamp.arrays import Array
from rockdamp.constants import MODELS, REFERENCE, SOFTENING
from rockdamp.equivalence.closed_form import equivalence_factor
from rockdamp.errors import check, check_choice, check_list, check_number, check_type
from rockdamp.histories.respond import record_attributes
from rockdamp.laboratory.calibration import true_values
from rockdamp.laboratory.free_decay import FreeDecay
from rockdamp.laboratory.free_rocking_file import FreeRocking
from rockdamp.laboratory.losses import fit_law, loss_at, regress
from rockdamp.laboratory.record_fit import PARAMETERS
from rockdamp.laboratory.releases import find_releases, rest_deviation
from rockdamp.laboratory.uncertainty import NORMAL, check_deviations
from rockdamp.mechanics.curve import RULES, TrilinearCurve
from rockdamp.mechanics.dampers import DAMPERS
from rockdamp.mechanics.damping import REFERENCE_AMPLITUDE, Damping
from rockdamp.mechanics.wall import Parapet, Wall

ASSESSED_AMPLITUDE = REFERENCE_AMPLITUDE  # of the e of an assessment, u/u_ins
AMPLITUDES = 0.1, ASSESSED_AMPLITUDE, 0.5


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

    Intervals of 90 % include the sensor's noise, zero and drift, and the `uncertain` sizes of the wall. The interval of
    the mean e also includes the estimated scatter from impact to impact. An error of the sensor's gain is not included.

    Parameters
    ----------
    tests : FreeRocking or sequence of them
        Each with one or more releases.
    wall : Wall or Parapet
        Its geometry and weights are taken as known, except for the `uncertain` ones: they give u_ins and p.
    ultimate_displacement_ratio, softening : float and str
        a3 and the variant of softening, taken as known.
    least_peak : float, optional
        Smallest peak that is used; by default ten standard deviations of the sensor's noise. [m]
    uncertain : dict of float, optional
        Standard deviations of sizes of the wall, by name, such as ``{"thickness": 0.002}``.

    Returns
    -------
    xarray.Dataset
        ``estimate``, ``standard_error`` and ``interval`` (parameter); ``impact_restitution`` with its interval
        (impact); ``restitution_at_amplitude`` (amplitude) and ``loss_exponent`` g, with intervals; the likelihood of
        the losses under each damper (damping_model); peaks and half periods (half_cycle); the measured and the fitted
        displacement (sample).

    Raises
    ------
    InputError
        If there are too few peaks, the specimen rocks to one side only, peaks exceed u_ins, or b1 lies at a bound
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
    >>> shown = np.concatenate([held, decay.control_displacement]) + 1e-4 * np.random.RandomState(
    ...     1
    ... ).standard_normal(3201)
    >>> test = rd.FreeRocking(0.002 * np.arange(3201), shown)
    >>> fitted = rd.fit_free_rocking(test, wall)
    >>> fitted.estimate.values.round(3)
    array([0.05, 0.8 , 0.88])
    """
    check_type("wall", wall, Wall, Parapet)
    a3 = check_number(
        "ultimate_displacement_ratio",
        ultimate_displacement_ratio,
        *RULES["ultimate_displacement_ratio"],
    )
    check_choice("softening", softening, SOFTENING)
    if least_peak is not None:
        check_number("least_peak", least_peak, lambda peak: peak > 0, "greater than 0 [m]")
    several = check_list("tests", tests, FreeRocking)
    deviations = check_deviations(wall, uncertain)
    u_ins, p = float(wall.instability_displacement), float(wall.frequency_parameter)
    # ASSUME: the measured rotation is small, and is the rotation of the lower body or of the parapet.
    lever = float(wall.lower_height if isinstance(wall, Wall) else wall.height)
    displacements = [test.measured * (1.0 if test.rotation is None else lever) for test in several]
    releases = [
        release
        for test, displacement in zip(several, displacements, strict=True)
        for release in find_releases(test.elapsed, displacement, least_peak)
    ]
    largest = max(float(np.abs(release.peaks).max()) for release in releases)
    check(
        "largest peak",
        largest,
        lambda u: u < a3 * u_ins,
        f"less than {a3 * u_ins:.4g} m, where the wall collapses",
    )
    fitted = _dataset(FreeDecay(releases, p, u_ins, a3, softening))
    estimate, variance = fitted["estimate"].values, np.zeros(len(PARAMETERS))
    kept: dict[str, Any] = {
        "ultimate_displacement_ratio": a3,
        "softening": softening,
        "least_peak": least_peak,
    }
    for name, deviation in deviations.items():
        sizes: list[Any] = [
            {name: float(getattr(wall, name)) + side * deviation} for side in (1, -1)
        ]
        large, small = (
            fit_free_rocking(tests, replace(wall, **size), **kept)["estimate"].values
            for size in sizes
        )
        variance += ((large - small) / 2) ** 2
    reach = np.sqrt((fitted["interval"].values - estimate) ** 2 + NORMAL**2 * variance)
    resting = [rest_deviation(displacement) for displacement in displacements]
    synthetic = "yes" if any(test.synthetic for test in several) else "no"
    return fitted.assign(
        standard_error=("parameter", np.sqrt(fitted["standard_error"].values ** 2 + variance)),
        interval=(
            ("bound", "parameter"),
            np.maximum(estimate + np.array([[-1.0], [1.0]]) * reach, 0.0),
        ),
        true_value=("parameter", true_values(several[0].header)),
        rest_deviation=np.nanmean(resting) if np.isfinite(resting).any() else np.nan,
        restitution_rigid=float(wall.restitution_rigid),
        restitution_impulsive=float(wall.restitution_impulsive),
        instability_displacement=u_ins,
        frequency_parameter=p,
    ).assign_attrs(record_attributes(several[0].header) | {"record_synthetic": synthetic})


def _dataset(decay: FreeDecay) -> xr.Dataset:
    """Fit the decay; return a1, b1, and e by the mean of the losses, the losses by amplitude and damper, histories."""
    point, covariance = decay.solution()
    values, covariance = _losses(decay, point, covariance)
    curve_values, losses, errors = values[:2], values[2:], np.sqrt(np.diag(covariance))
    curve, before = (
        decay.curve(*point[:2]),
        np.concatenate([np.exp(point[part][3:-1]) for part in decay.slices]),
    )
    # ASSUME: below u1 a wall vibrates on its first branch and does not rock: its loss there is no restitution.
    rocking = before > curve_values[0]
    fewest = "at least 3: release it from further out"
    check("impacts after a peak above u1", np.count_nonzero(rocking), lambda n: n >= 3, fewest)
    rocking_losses = losses[rocking], covariance[2:, 2:][rocking][:, rocking]
    mean = regress(*rocking_losses, np.ones((np.count_nonzero(rocking), 1)))
    decrement, error = float(mean.coefficients[0]), float(np.sqrt(mean.covariance[0, 0]))
    sides, widest = (
        np.array([-1, 1]),
        10.0,
    )  # half of an interval of ln e, which a peak in the noise leaves unbounded
    e, reach = np.exp(-decrement), min(_quantile(losses[rocking].size - 1) * error, widest)
    curve_bounds = curve_values + NORMAL * np.outer(sides, errors[:2])
    own_reach = np.minimum(NORMAL * errors[2:], widest)
    return xr.Dataset(
        {
            "estimate": ("parameter", np.array([*curve_values, e])),
            "standard_error": ("parameter", np.array([*errors[:2], e * error])),
            "interval": (
                ("bound", "parameter"),
                np.column_stack([curve_bounds, np.exp(-decrement + reach * sides)]),
            ),
            "impact_restitution": ("impact", np.exp(-losses)),
            "impact_restitution_interval": (
                ("bound", "impact"),
                np.exp(-losses) * np.exp([-own_reach, own_reach]),
            ),
            "impact_amplitude": ("impact", before),
            "impact_rocking": ("impact", rocking.astype(int)),
            "restitution_scatter": mean.scatter,
            **_law(*rocking_losses, curve, before[rocking]),
            **_dampers(*rocking_losses, curve, before, rocking, e),
            **_histories(decay, point),
        },
        coords={
            "parameter": list(PARAMETERS),
            "bound": ["low", "high"],
            "damping_model": list(MODELS),
            "release": np.arange(1, len(decay.releases) + 1),
            "impact": np.arange(1, before.size + 1),
            "amplitude": list(AMPLITUDES),
        },
    )


def _quantile(degrees_of_freedom: int) -> float:
    """Return Student's quantile of an interval of 90 %."""
    return float(student.ppf(0.95, max(degrees_of_freedom, 1)))


def _losses(decay: FreeDecay, point: Array, covariance: Array) -> tuple[Array, Array]:
    """Return a1, b1 and the losses of all impacts, and their covariance by the sensor."""

    def derived(points: Array) -> Array:
        curve = decay.curve(points[:, :1], points[:, 1:2])
        energies = [curve.energy(np.exp(points[:, part][:, 3:])) for part in decay.slices]
        losses = [0.5 * np.log(energy[:, :-1] / energy[:, 1:]) for energy in energies]
        return np.concatenate(
            [curve.yield_displacement_ratio, curve.strength_ratio, *losses], axis=1
        )

    h = 1e-5
    sides = derived(
        np.concatenate([point + h * np.eye(point.size), point - h * np.eye(point.size)])
    )
    gradient = ((sides[: point.size] - sides[point.size :]) / (2 * h)).T
    return derived(point[None])[0], gradient @ covariance @ gradient.T


def _law(
    losses: Array, covariance: Array, curve: TrilinearCurve, before: Array
) -> dict[str, object]:
    """Return g of the law of loss, and e at `AMPLITUDES` by it."""
    log_energy = np.log(curve.energy(before))
    middle, quantile = log_energy.mean(), _quantile(losses.size - 2)
    point, point_covariance = fit_law(losses, covariance, log_energy - middle)
    at = [
        loss_at(point, point_covariance, float(np.log(curve.energy(amplitude)) - middle))
        for amplitude in AMPLITUDES
    ]
    loss, error = np.array(at).T
    g_reach = quantile * np.sqrt(point_covariance[1, 1])
    ends = [np.exp(-np.maximum(loss + side * quantile * error, 0.0)) for side in (1, -1)]
    return {
        "loss_exponent": point[1],
        "loss_exponent_interval": ("bound", point[1] + g_reach * np.array([-1, 1])),
        "restitution_at_amplitude": ("amplitude", np.exp(-loss)),
        "restitution_at_amplitude_interval": (("bound", "amplitude"), np.array(ends)),
    }


def _dampers(
    losses: Array, covariance: Array, curve: TrilinearCurve, before: Array, rocking: Array, e: float
) -> dict[str, object]:
    """Return the exponent and the restitution of each damper on this curve, and the likelihood of the losses."""
    energy = curve.energy(before[rocking])
    middle = curve.amplitude(
        e * energy
    )  # of a half cycle: with it a damper's loss is of second order
    likelihoods, exponents = [], []
    restitution = np.full((len(MODELS), rocking.size), np.nan)
    for index, model in enumerate(MODELS):
        shape = np.ones(losses.size)
        if model != REFERENCE and not DAMPERS[model].is_amplitude_independent:
            shape = 1 / equivalence_factor(curve, Damping(model, 1.0), middle)
        line = regress(losses, covariance, (shape / shape.mean())[:, None], restricted=False)
        likelihoods.append(line.log_likelihood)
        exponents.append(-float(np.polyfit(np.log(energy), np.log(shape), 1)[0]))
        restitution[index, rocking] = np.exp(-line.coefficients[0] * shape / shape.mean())
    left = max(losses.size - 2, 1)
    return {
        "expected_exponent": ("damping_model", np.array(exponents)),
        "expected_restitution": (("damping_model", "impact"), restitution),
        "relative_log_likelihood": ("damping_model", np.array(likelihoods) - max(likelihoods)),
        # Of an interval of a parameter, exact for equal variances.
        "log_likelihood_threshold": -0.5
        * losses.size
        * float(np.log1p(_quantile(left) ** 2 / left)),
    }


def _histories(decay: FreeDecay, point: Array) -> dict[str, object]:
    """Return releases, half cycles, impacts and samples, each one release after the other."""
    u_ins, parts = decay.u_ins, []
    for index, (release, own) in enumerate(
        zip(decay.releases, (point[part] for part in decay.slices), strict=True)
    ):
        start, side = release.elapsed[0], np.sign(release.peaks)
        crossing, peak, amplitude = (values[0] for values in decay.times(point[None], index))
        parts.append(
            {
                "release_elapsed": ("release", start + peak[:1] / decay.p),
                "release_displacement": ("release", u_ins * side[:1] * amplitude[:1]),
                "sensor_zero": ("release", release.zero + u_ins * own[1:2]),
                "sensor_drift": ("release", u_ins * own[2:3] / (release.elapsed[-1] - start)),
                "half_cycle_release": ("half_cycle", np.full(amplitude.size, index + 1)),
                "peak_elapsed": ("half_cycle", start + peak / decay.p),
                "peak_displacement": ("half_cycle", u_ins * side * amplitude),
                "half_period": (
                    "half_cycle",
                    np.concatenate([[np.nan], np.diff(release.crossings), [np.nan]]),
                ),
                "half_period_fitted": (
                    "half_cycle",
                    decay.curve(*point[:2]).period(amplitude) / (2 * decay.p),
                ),
                "impact_release": ("impact", np.full(crossing.size, index + 1)),
                "impact_elapsed": ("impact", start + crossing / decay.p),
                "sample_release": ("sample", np.full(release.elapsed.size, index + 1)),
                "sample_elapsed": ("sample", release.elapsed),
                "measured": (
                    "sample",
                    u_ins * (decay.measured[index] - decay.trend(point[None], index)[0]),
                ),
                "control_displacement": ("sample", u_ins * decay.computed(point[None], index)[0]),
            }
        )
    residual = u_ins * decay.residual(point)
    return {
        **{
            name: (dim, np.concatenate([part[name][1] for part in parts]))
            for name, (dim, _) in parts[0].items()
        },
        "residual_rms": float(np.sqrt(residual @ residual / (residual.size - point.size))),
    }
