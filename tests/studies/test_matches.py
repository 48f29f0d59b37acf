"""The studies' matched damping ratios."""

import copy

import numpy as np
import pytest

from rockdamp.studies import damping_loops, polynomial_fits, pulses
from rockdamp.studies.decays import study as decay_study
from rockdamp.studies.earthquakes import incremental
from rockdamp.studies.matches import match
from rockdamp.studies.settings import PulseSettings
from rockdamp.vocabulary import STUDIES


@pytest.mark.parametrize("name", STUDIES)
def test_the_matched_error_is_what_the_definition_gives(name, matches, config):
    match = matches[name]
    assert float(match["steps"] * match["step"]) == pytest.approx(float(match["window"]))
    np.testing.assert_allclose(match["rms_error"], np.sqrt(match["error"] / match["steps"]))
    assert (match["local_minima"] >= 1).all()
    assert (match["damping_ratio_uncertainty"] < 0.03 * match["damping_ratio"]).all()


def test_damping_grows_as_restitution_falls(matches):
    for matched in matches.values():
        assert (matched["damping_ratio"].diff("restitution") < 0).all()


def test_equal_lengths_in_tau_make_walls_equal_and_equal_seconds_do_not(matches):
    for name, parameter in (("slenderness", "slenderness"), ("overburden", "overburden_ratio")):
        match = matches[name]
        assert float((match["damping_ratio"].max(parameter) - match["damping_ratio"].min(parameter)).max()) == 0.0
        fixed = match["damping_ratio_fixed_seconds"]
        assert float((fixed.max(parameter) - fixed.min(parameter)).max()) > 1e-4


def test_the_reference_wall_is_the_same_at_a_fixed_length_in_seconds(matches, config):
    match = matches["slenderness"].sel(slenderness=config["wall"]["slenderness"])
    np.testing.assert_allclose(match["damping_ratio_fixed_seconds"], match["damping_ratio"], rtol=1e-6)


def test_studies_agree_where_they_meet(matches):
    """Every study holds the reference wall: a1 = 0.04, released at 0.5."""
    values = [
        matches["amplitude"]["damping_ratio"].sel(release_amplitude=0.5).values,
        matches["slenderness"]["damping_ratio"].sel(slenderness=15).values,
        matches["overburden"]["damping_ratio"].sel(overburden_ratio=0).values,
        matches["cracked_stiffness"]["damping_ratio"].sel(cracked_stiffness_ratio=0.04).values,
    ]
    for other in values[1:]:
        np.testing.assert_allclose(other, values[0], rtol=1e-6)


@pytest.mark.parametrize("scheme", ["newmark", "paper"])
def test_every_stage_publishes_the_same_damping_ratio_of_a_wall(config, scheme):
    """The reference wall at one e: by the studies, the loops, the pulses and the earthquakes, in either scheme."""
    e = 0.82
    small = copy.deepcopy(config)
    small["solver"]["scheme"] = scheme
    small["restitution"] = {"start": 0.78, "stop": 0.86, "step": 0.04}
    small["studies"]["cracked_stiffness"]["cracked_stiffness_ratio"] = [0.04]
    small["loops"]["restitution"] = e
    small["pulses"]["restitution"] = [0.8, e]
    small["natural"]["restitution"] = [e]
    studied = match("cracked_stiffness", small, decay_study("cracked_stiffness", small))
    published = studied["damping_ratio"].sel(restitution=e).squeeze().values
    looped = damping_loops.loops(small)["damping_ratio"].values[1:]
    pulsed = pulses.damping_ratios(PulseSettings.of(small))[pulses.SOURCES.index("error"), :, 1]
    shaken = incremental.walls(small, polynomial_fits.fit(small, studied))["damping_ratio"]
    top_storey = shaken.sel(wall="top storey", damping_ratio_source="error", restitution=e).values[1:]
    for other in (looped, pulsed, top_storey):
        np.testing.assert_array_equal(other, published)
