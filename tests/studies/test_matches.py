"""The studies' matched damping ratios."""

import numpy as np
import pytest
from configs import changed, configured

from rockdamp.config import Grid
from rockdamp.constants import STUDIES
from rockdamp.equivalence.matching import Cases, global_minima
from rockdamp.studies import earthquakes, polynomial_fits
from rockdamp.studies.damping_force import damping_force
from rockdamp.studies.decays import decay
from rockdamp.studies.matches import match


@pytest.fixture(params=STUDIES)
def study_match(request, matches):
    return matches[request.param]


def test_response_has_its_length(study_match):
    length = float(study_match["steps"] * study_match["step"])
    assert length == pytest.approx(float(study_match["response_length"]))


def test_rms_error_is_that_of_the_sum(study_match):
    expected = np.sqrt(study_match["error"] / study_match["steps"])
    np.testing.assert_allclose(study_match["rms_error"], expected)


def test_every_match_is_a_minimum(study_match):
    assert (study_match["local_minima"] >= 1).all()


def test_uncertainty_is_small(study_match):
    assert (study_match["damping_ratio_uncertainty"] < 0.03 * study_match["damping_ratio"]).all()


WALL_STUDIES = [("slenderness", "slenderness"), ("overburden", "overburden_ratio")]


@pytest.mark.parametrize(("name", "parameter"), WALL_STUDIES)
def test_equal_lengths_in_tau_make_walls_equal(matches, name, parameter):
    ratio = matches[name]["damping_ratio"]
    assert float((ratio.max(parameter) - ratio.min(parameter)).max()) == 0.0


@pytest.mark.parametrize(("name", "parameter"), WALL_STUDIES)
def test_equal_seconds_make_walls_differ(matches, name, parameter):
    ratio = matches[name]["damping_ratio_fixed_seconds"]
    assert float((ratio.max(parameter) - ratio.min(parameter)).max()) > 1e-4


@pytest.mark.parametrize("model", ["CDC", "SDR"])
@pytest.mark.parametrize(("name", "parameter"), WALL_STUDIES)
def test_fixed_seconds_are_the_length_of_each_wall(matches, config, name, parameter, model):
    """The last wall, study_match over the same seconds."""
    study_match = matches[name]
    value = float(study_match[parameter][-1])
    wall = configured({"wall": {parameter: value}}).wall.make()
    reference = configured().wall.make()
    scale = wall.frequency_parameter / reference.frequency_parameter
    step = config.solver.step
    steps = round(float(study_match["response_length"]) * scale / step)
    e = study_match["restitution"].values[[0, 3]]
    curve = config.curve.make().map(lambda ratio: np.full(2, ratio))
    release = np.full(2, config.release_amplitude)
    cases = Cases.release(curve, release, e, step=step, steps=steps)
    expected = global_minima(cases, model, [steps]).damping_ratio[0]
    ratio = study_match["damping_ratio_fixed_seconds"].sel(
        {parameter: value, "damping_model": model}
    )
    np.testing.assert_allclose(ratio.sel(restitution=e), expected, rtol=1e-9)


@pytest.mark.parametrize(
    ("name", "reference"),
    [
        ("slenderness", {"slenderness": 15}),
        ("overburden", {"overburden_ratio": 0}),
        ("cracked_stiffness", {"yield_displacement_ratio": 0.04}),
    ],
)
def test_studies_agree_on_the_reference_wall(matches, name, reference):
    expected = matches["amplitude"]["damping_ratio"].sel(release_amplitude=0.5)
    ratio = matches[name]["damping_ratio"].sel(reference)
    np.testing.assert_allclose(ratio, expected, rtol=1e-6)


@pytest.mark.parametrize("scheme", ["newmark", "paper"])
def test_stages_publish_one_damping_ratio_of_a_wall(config, scheme):
    """The reference wall at one e: by the studies, the loops and the earthquakes."""
    e = 0.82
    values = {
        "solver.scheme": scheme,
        "restitution": Grid(start=0.78, stop=0.86, step=0.04),
        "damping_force.restitution": e,
        "studies.cracked_stiffness": [0.04],
        "earthquakes.restitution": [e],
    }
    small = changed(config, values)
    study_match = match("cracked_stiffness", small, decay("cracked_stiffness", small))
    published = study_match["damping_ratio"].sel(restitution=e).squeeze().values
    by_loops = damping_force(small)["damping_ratio"].values[1:]
    walls = earthquakes.walls(small, polynomial_fits.fit(small, study_match))
    by_earthquakes = walls["damping_ratio"].sel(
        wall="top storey", damping_ratio_source="least error", restitution=e
    )
    np.testing.assert_array_equal(by_loops, published)
    np.testing.assert_array_equal(by_earthquakes.values[1:], published)
