"""Free-rocking tests: the curve by half periods, e by energies of peaks, likely dampers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.stats import t as student

from rockdamp.arrays import Array
from rockdamp.constants import MODELS, REFERENCE, SOFTENING
from rockdamp.equivalence.closed_form import equivalence_factor
from rockdamp.errors import InputError, check_choice, check_list, check_number, check_type
from rockdamp.histories.respond import record_attributes
from rockdamp.laboratory.calibration import true_values
from rockdamp.laboratory.free_decay import FreeDecay
from rockdamp.laboratory.free_rocking_file import FreeRocking
from rockdamp.laboratory.losses import fit_law, loss_at, regress
from rockdamp.laboratory.record_fit import PARAMETERS
from rockdamp.laboratory.releases import find_releases, rest_deviation
from rockdamp.laboratory.uncertainty import NORMAL_QUANTILE, check_deviations, differentiate
from rockdamp.mechanics.curve import CURVE_RULES, TrilinearCurve
from rockdamp.mechanics.damping import DAMPERS, REFERENCE_AMPLITUDE, Damping
from rockdamp.mechanics.wall import Parapet, Wall
from rockdamp.text import count_noun

# Amplitudes u/u_ins at which e is stated; an assessment takes the middle one.
STATED_AMPLITUDES = 0.1, REFERENCE_AMPLITUDE, 0.5
SIDES = np.array([-1, 1])  # of an interval


def fit_free_rocking(
    tests: FreeRocking | Sequence[FreeRocking],
    wall: Wall | Parapet,
    *,
    ultimate_displacement_ratio: float = 1.0,
    softening: str = "steeper",
    least_peak: float | None = None,
    uncertain: Mapping[str, float] | None = None,
) -> xr.Dataset:
    r"""Fit a1, b1, e and the exponent g of the losses to free-rocking tests of one specimen.

    Between impacts the wall moves freely, in closed form. Least squares fit this motion to each
    whole decay, with an amplitude for each half cycle, a1, b1, and the sensor's zero and drift. The
    energies V of two peaks give the loss of the impact between them, ``-ln e = ln(V_k/V_(k+1))/2``;
    half periods give a1 and b1. Then the losses of all impacts are averaged. Section 8 of
    docs/theory.md has the law of the losses with its exponent g.

    The 90 % intervals include the sensor's noise, zero and drift, and the `uncertain` sizes of the
    wall. The interval of the mean e also includes the estimated scatter from impact to impact. An
    error of the sensor's gain is not included.

    Parameters
    ----------
    tests : FreeRocking or sequence of FreeRocking
        Tests of one specimen, each with one or more releases.
    wall : Wall or Parapet
        Sizes and weights of the specimen, exact except for those in `uncertain`. They give u_ins
        and p.
    ultimate_displacement_ratio : float
        Known a3, in (0, 1]. Default: 1. [-]
    softening : {"steeper", "translated"}
        Known variant of the softening branch. Default: "steeper".
    least_peak : float, optional
        Smallest peak that is used. Default: ten standard deviations of the sensor's noise. [m]
    uncertain : dict of float, optional
        Standard deviations of sizes of the wall, by name, such as ``{"thickness": 0.002}``.
        Default: none.

    Returns
    -------
    xarray.Dataset
        ``estimate``, ``standard_error`` and ``interval`` (parameter); ``impact_restitution`` with
        its interval (impact); ``restitution_at_amplitude`` (amplitude) and ``loss_exponent`` g,
        with intervals; the likelihood of the losses under each damper (damping_model); peaks and
        half periods (half_cycle); the measured and the fitted displacement (sample).

    Raises
    ------
    InputError
        If there are too few peaks, samples are lost, the specimen rocks to one side only, a peak
        exceeds u_ins, or b1 lies at a bound of the search.

    Examples
    --------
    >>> import numpy as np
    >>> import rockdamp as rd
    >>> wall = rd.Wall(thickness=0.25, height=3.0)
    >>> curve, damping = rd.TrilinearCurve(0.05, 0.80), rd.Damping("CR", 0.88)
    >>> p = float(wall.frequency_parameter)
    >>> decay = rd.free_decay(curve, damping, wall=wall, length=6.0 * p, step=0.002 * p)
    >>> displacement = np.concatenate([np.full(200, 0.125), decay.control_displacement])
    >>> noise = 1e-4 * np.random.RandomState(1).standard_normal(displacement.size)
    >>> elapsed = 0.002 * np.arange(displacement.size)
    >>> test = rd.FreeRocking(elapsed, displacement + noise)
    >>> fitted = rd.fit_free_rocking(test, wall)
    >>> fitted.estimate.values.round(3)
    array([0.05, 0.8 , 0.88])
    """
    check_type("wall", wall, Wall, Parapet)
    a3 = check_number(
        "ultimate_displacement_ratio",
        ultimate_displacement_ratio,
        *CURVE_RULES["ultimate_displacement_ratio"],
    )
    check_choice("softening", softening, SOFTENING)
    if least_peak is not None:
        check_number("least_peak", least_peak, lambda peak: peak > 0, "greater than 0 [m]")
    test_list = check_list("tests", tests, FreeRocking)
    deviations = check_deviations(wall, uncertain)
    displacements = [_displacement(test, wall) for test in test_list]
    decay = _make_decay(test_list, displacements, wall, a3, softening, least_peak)
    fitted = _fit_decay(decay)

    def fit_size(name: str, size: float) -> Array:
        sized: dict[str, Any] = {name: size}
        fit = fit_free_rocking(
            test_list,
            replace(wall, **sized),
            ultimate_displacement_ratio=a3,
            softening=softening,
            least_peak=least_peak,
        )
        return fit["estimate"].values

    size_variance = np.zeros(len(PARAMETERS))
    for name, deviation in deviations.items():
        size = float(getattr(wall, name))
        change = fit_size(name, size + deviation) - fit_size(name, size - deviation)
        size_variance += (change / 2) ** 2
    estimate = fitted["estimate"].values
    reach = np.sqrt(
        (fitted["interval"].values - estimate) ** 2 + NORMAL_QUANTILE**2 * size_variance
    )
    standard_error = np.sqrt(fitted["standard_error"].values ** 2 + size_variance)
    resting = [rest_deviation(displacement) for displacement in displacements]
    header = test_list[0].header
    is_synthetic = any(test.synthetic for test in test_list)
    return fitted.assign(
        standard_error=("parameter", standard_error),
        interval=(("bound", "parameter"), np.maximum(estimate + SIDES[:, None] * reach, 0.0)),
        true_value=("parameter", true_values(header)),
        rest_deviation=np.nanmean(resting) if np.isfinite(resting).any() else np.nan,
        restitution_rigid=float(wall.restitution_rigid),
        restitution_impulsive=float(wall.restitution_impulsive),
        instability_displacement=decay.u_ins,
        frequency_parameter=decay.p,
    ).assign_attrs(
        record_attributes(header) | {"record_synthetic": "yes" if is_synthetic else "no"}
    )


def _displacement(test: FreeRocking, wall: Wall | Parapet) -> Array:
    """Return the measured displacement at the hinge, or at the top of a parapet. [m]"""
    if test.rotation is None:
        return test.measured
    # ASSUME: the measured rotation is small, and is that of the lower body or of the parapet.
    lever = wall.lower_height if isinstance(wall, Wall) else wall.height
    return test.rotation * float(lever)


def _make_decay(
    tests: Sequence[FreeRocking],
    displacements: Sequence[Array],
    wall: Wall | Parapet,
    a3: float,
    softening: str,
    least_peak: float | None,
) -> FreeDecay:
    """Return the releases of all tests as one problem; refuse peaks of a collapsed wall."""
    releases = []
    for test, displacement in zip(tests, displacements, strict=True):
        releases += find_releases(test.elapsed, displacement, least_peak)
    u_ins = float(wall.instability_displacement)
    largest_peak = max(float(np.abs(release.peaks).max()) for release in releases)
    if largest_peak >= a3 * u_ins:
        raise InputError(
            f"largest peak is {largest_peak:.3g} m; it must be less than {a3 * u_ins:.3g} m, where"
            " the wall collapses: check the unit of the column and the sizes of the wall"
        )
    return FreeDecay(releases, float(wall.frequency_parameter), u_ins, a3, softening)


# --- estimates ------------------------------------------------------------------------------------


class _Impacts(NamedTuple):
    """Losses of impacts with their covariance, and the amplitudes before them. [u_ins]"""

    loss: Array
    covariance: Array
    amplitude: Array

    def take(self, chosen: NDArray[np.bool_]) -> _Impacts:
        """Return some of the impacts."""
        return _Impacts(
            self.loss[chosen], self.covariance[chosen][:, chosen], self.amplitude[chosen]
        )


def _fit_decay(decay: FreeDecay) -> xr.Dataset:
    """Fit the decay; return a1, b1, the mean e, losses by amplitude and damper, and histories."""
    point, point_covariance = decay.solution()
    values, covariance = _curve_and_losses(decay, point, point_covariance)
    curve_values = values[:2]
    errors = np.sqrt(np.diag(covariance))
    curve = decay.curve(*point[:2])
    amplitudes = [np.exp(point[part][3:-1]) for part in decay.slices]
    impacts = _Impacts(values[2:], covariance[2:, 2:], np.concatenate(amplitudes))
    # ASSUME: below u1 a wall vibrates on its first branch and does not rock: its loss there is no
    # restitution.
    is_rocking = impacts.amplitude > curve_values[0]
    rocking_count = int(np.count_nonzero(is_rocking))
    if rocking_count < 3:
        raise InputError(
            f"only {count_noun(rocking_count, 'impact')} follow a peak above u1; at least 3 are"
            " needed: release the wall from further out"
        )
    rocking = impacts.take(is_rocking)
    mean = regress(rocking.loss, rocking.covariance, np.ones((rocking_count, 1)))
    decrement = float(mean.coefficients[0])
    error = float(np.sqrt(mean.covariance[0, 0]))
    e = np.exp(-decrement)
    widest = 10.0  # half of an interval of ln e, which a peak within the noise leaves unbounded
    reach = min(_student_quantile(rocking_count - 1) * error, widest)
    curve_bounds = curve_values + NORMAL_QUANTILE * np.outer(SIDES, errors[:2])
    e_bounds = np.exp(-decrement + reach * SIDES)
    impact_reach = np.minimum(NORMAL_QUANTILE * errors[2:], widest)
    impact_restitution = np.exp(-impacts.loss)
    return xr.Dataset(
        {
            "estimate": ("parameter", np.array([*curve_values, e])),
            "standard_error": ("parameter", np.array([*errors[:2], e * error])),
            "interval": (("bound", "parameter"), np.column_stack([curve_bounds, e_bounds])),
            "impact_restitution": ("impact", impact_restitution),
            "impact_restitution_interval": (
                ("bound", "impact"),
                impact_restitution * np.exp([-impact_reach, impact_reach]),
            ),
            "impact_amplitude": ("impact", impacts.amplitude),
            "impact_rocking": ("impact", is_rocking.astype(int)),
            "restitution_scatter": mean.scatter,
            **_fit_loss_law(rocking, curve),
            **_compare_dampers(rocking, curve, is_rocking, e),
            **_histories(decay, point),
        },
        coords={
            "parameter": list(PARAMETERS),
            "bound": ["low", "high"],
            "damping_model": list(MODELS),
            "release": np.arange(1, len(decay.releases) + 1),
            "impact": np.arange(1, impacts.loss.size + 1),
            "amplitude": list(STATED_AMPLITUDES),
        },
    )


def _student_quantile(degrees_of_freedom: int) -> float:
    """Return Student's quantile for an interval of 90 %."""
    return float(student.ppf(0.95, max(degrees_of_freedom, 1)))


def _curve_and_losses(decay: FreeDecay, point: Array, covariance: Array) -> tuple[Array, Array]:
    """Return a1, b1 and the losses of all impacts, and their covariance by the sensor.

    The loss is -ln e = ln(V_k/V_(k+1))/2, with V_k and V_(k+1) the energies of the peaks around it.
    """

    def derive(points: Array) -> Array:
        curve = decay.curves(points)
        losses = []
        for part in decay.slices:
            energy = curve.energy(np.exp(points[:, part][:, 3:]))
            losses.append(0.5 * np.log(energy[:, :-1] / energy[:, 1:]))
        return np.concatenate(
            [curve.yield_displacement_ratio, curve.strength_ratio, *losses], axis=1
        )

    gradient = differentiate(derive, point)
    return derive(point[None])[0], gradient @ covariance @ gradient.T


def _fit_loss_law(impacts: _Impacts, curve: TrilinearCurve) -> dict[str, object]:
    """Return g of the law of loss, and e at `STATED_AMPLITUDES` by it."""
    log_energy = np.log(curve.energy(impacts.amplitude))
    reference = log_energy.mean()
    quantile = _student_quantile(impacts.loss.size - 2)
    point, covariance = fit_law(impacts.loss, impacts.covariance, log_energy - reference)
    stated_log_energies = [float(np.log(curve.energy(x)) - reference) for x in STATED_AMPLITUDES]
    losses, errors = np.transpose(
        [loss_at(point, covariance, stated) for stated in stated_log_energies]
    )
    g = point[1]
    g_reach = quantile * np.sqrt(covariance[1, 1])
    # The larger loss comes first, as it gives the lower e.
    loss_bounds = np.maximum(losses - SIDES[:, None] * quantile * errors, 0.0)
    return {
        "loss_exponent": g,
        "loss_exponent_interval": ("bound", g + g_reach * SIDES),
        "restitution_at_amplitude": ("amplitude", np.exp(-losses)),
        "restitution_at_amplitude_interval": (("bound", "amplitude"), np.exp(-loss_bounds)),
    }


def _compare_dampers(
    rocking: _Impacts, curve: TrilinearCurve, is_rocking: NDArray[np.bool_], e: float
) -> dict[str, object]:
    """Return each damper's exponent and restitution on this curve, and its likelihood."""
    energy = curve.energy(rocking.amplitude)
    # A closed form of first order in the loss is of second order at the energy e V, the geometric
    # mean of the energies V and e^2 V at both ends of a half cycle.
    middle = curve.amplitude(e * energy)
    log_likelihoods = []
    exponents = []
    restitution = np.full((len(MODELS), is_rocking.size), np.nan)
    for index, model in enumerate(MODELS):
        shape = np.ones(rocking.loss.size)
        if model != REFERENCE and not DAMPERS[model].is_amplitude_independent:
            shape = 1 / equivalence_factor(curve, Damping(model, 1.0), middle)
        relative = shape / shape.mean()
        line = regress(rocking.loss, rocking.covariance, relative[:, None], restricted=False)
        log_likelihoods.append(line.log_likelihood)
        slope, _ = np.polyfit(np.log(energy), np.log(shape), 1)
        exponents.append(-float(slope))
        restitution[index, is_rocking] = np.exp(-line.coefficients[0] * shape / shape.mean())
    degrees_of_freedom = max(rocking.loss.size - 2, 1)
    quantile = _student_quantile(degrees_of_freedom)
    # The log-likelihood at the ends of a 90 % interval of one parameter, less its maximum. It is
    # exact if all losses have the same variance.
    threshold = -0.5 * rocking.loss.size * float(np.log1p(quantile**2 / degrees_of_freedom))
    return {
        "expected_exponent": ("damping_model", np.array(exponents)),
        "expected_restitution": (("damping_model", "impact"), restitution),
        "relative_log_likelihood": (
            "damping_model",
            np.array(log_likelihoods) - max(log_likelihoods),
        ),
        "log_likelihood_threshold": threshold,
    }


# --- histories ------------------------------------------------------------------------------------


def _histories(decay: FreeDecay, point: Array) -> dict[str, object]:
    """Return releases, half cycles, impacts and samples, each one release after the other."""
    parts = [_release_history(decay, point, index) for index in range(len(decay.releases))]
    variables: dict[str, object] = {}
    for name, (dim, _) in parts[0].items():
        variables[name] = dim, np.concatenate([part[name][1] for part in parts])
    residual = decay.u_ins * decay.residual(point)
    variables["residual_rms"] = float(np.sqrt(residual @ residual / (residual.size - point.size)))
    return variables


def _release_history(decay: FreeDecay, point: Array, index: int) -> dict[str, tuple[str, Array]]:
    """Return the variables of one release, each with its dimension."""
    release = decay.releases[index]
    u_ins = decay.u_ins
    _, zero, drift, *_ = point[decay.slices[index]]
    points = point[None]
    excursions = decay.excursions(points, index)
    crossing, peak, amplitude = (values[0] for values in excursions)
    start = release.elapsed[0]
    peak_elapsed = start + peak / decay.p
    peak_displacement = u_ins * np.sign(release.peaks) * amplitude
    duration = release.elapsed[-1] - start
    half_period = np.concatenate([[np.nan], np.diff(release.crossings), [np.nan]])
    fitted_half_period = decay.curve(*point[:2]).period(amplitude) / (2 * decay.p)
    measured = decay.measured[index] - decay.trend(points, index)[0]
    number = index + 1
    return {
        "release_elapsed": ("release", peak_elapsed[:1]),
        "release_displacement": ("release", peak_displacement[:1]),
        "sensor_zero": ("release", np.array([release.zero + u_ins * zero])),
        "sensor_drift": ("release", np.array([u_ins * drift / duration])),
        "half_cycle_release": ("half_cycle", np.full(amplitude.size, number)),
        "peak_elapsed": ("half_cycle", peak_elapsed),
        "peak_displacement": ("half_cycle", peak_displacement),
        "half_period": ("half_cycle", half_period),
        "half_period_fitted": ("half_cycle", fitted_half_period),
        "impact_release": ("impact", np.full(crossing.size, number)),
        "impact_elapsed": ("impact", start + crossing / decay.p),
        "sample_release": ("sample", np.full(release.elapsed.size, number)),
        "sample_elapsed": ("sample", release.elapsed),
        "measured": ("sample", u_ins * measured),
        "control_displacement": ("sample", u_ins * decay.computed(points, index)[0]),
    }
