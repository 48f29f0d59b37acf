"""The studies' matched damping ratios."""

import numpy as np
import pytest
from configs import changed, configured

from rockdamp.config import Grid
from rockdamp.constants import STUDIES
from rockdamp.equivalence.matching import Cases, global_minima
from rockdamp.studies import earthquakes, polynomial_fits
from rockdamp.studies.damping_force import damping_force
from rockdamp.studies.decays import decay as decay_study
from rockdamp.studies.matches import match


@pytest.mark.parametrize("name", STUDIES)
def test_the_matched_error_is_what_the_definition_gives(name, matches, config):
    match = matches[name]
    assert float(match["steps"] * match["step"]) == pytest.approx(float(match["response_length"]))
    np.testing.assert_allclose(match["rms_error"], np.sqrt(match["error"] / match["steps"]))
    assert (match["local_minima"] >= 1).all()
    assert (match["damping_ratio_uncertainty"] < 0.03 * match["damping_ratio"]).all()


@pytest.mark.parametrize(
    ("name", "parameter"), [("slenderness", "slenderness"), ("overburden", "overburden_ratio")]
)
def test_equal_lengths_in_tau_make_walls_equal_and_equal_seconds_do_not(
    name, parameter, matches, config
):
    matched = matches[name]
    assert (
        float(
            (
                matched["damping_ratio"].max(parameter) - matched["damping_ratio"].min(parameter)
            ).max()
        )
        == 0.0
    )
    fixed = matched["damping_ratio_fixed_seconds"]
    assert float((fixed.max(parameter) - fixed.min(parameter)).max()) > 1e-4
    # The last wall, matched over what those seconds are in tau for it.
    given, value = config, float(matched[parameter][-1])
    restitution = matched["restitution"].values[[0, 3]]
    reference, wall = (
        configured({"wall": sizes}).wall.make() for sizes in ({}, {parameter: value})
    )
    length = (
        float(matched["response_length"]) * wall.frequency_parameter / reference.frequency_parameter
    )
    step, steps = given.solver.step, round(length / given.solver.step)
    curve, release = (
        given.curve.make().map(lambda value: np.full(2, value)),
        np.full(2, given.release_amplitude),
    )
    cases = Cases.release(curve, release, restitution, step=step, steps=steps)
    for model in ("CDC", "SDR"):
        alike = global_minima(cases, model, [steps]).damping_ratio[0]
        own = fixed.sel({parameter: value, "damping_model": model}).sel(restitution=restitution)
        np.testing.assert_allclose(own, alike, rtol=1e-9)


def test_studies_agree_where_they_meet(matches):
    """Every study holds the reference wall: a1 = 0.04, released at 0.5."""
    values = [
        matches["amplitude"]["damping_ratio"].sel(release_amplitude=0.5).values,
        matches["slenderness"]["damping_ratio"].sel(slenderness=15).values,
        matches["overburden"]["damping_ratio"].sel(overburden_ratio=0).values,
        matches["cracked_stiffness"]["damping_ratio"].sel(yield_displacement_ratio=0.04).values,
    ]
    for other in values[1:]:
        np.testing.assert_allclose(other, values[0], rtol=1e-6)


@pytest.mark.parametrize("scheme", ["newmark", "paper"])
def test_every_stage_publishes_the_same_damping_ratio_of_a_wall(config, scheme):
    """The reference wall at one e: by the studies, the loops and the earthquakes, in either scheme."""
    e = 0.82
    values = {
        "solver.scheme": scheme,
        "restitution": Grid(start=0.78, stop=0.86, step=0.04),
        "damping_force.restitution": e,
    }
    values |= {"studies.cracked_stiffness": [0.04]}
    values |= {"earthquakes.restitution": [e]}
    small = changed(config, values)
    studied = match("cracked_stiffness", small, decay_study("cracked_stiffness", small))
    published = studied["damping_ratio"].sel(restitution=e).squeeze().values
    looped = damping_force(small)["damping_ratio"].values[1:]
    shaken = earthquakes.walls(small, polynomial_fits.fit(small, studied))["damping_ratio"]
    top_storey = shaken.sel(
        wall="top storey", damping_ratio_source="least error", restitution=e
    ).values[1:]
    for other in (looped, top_storey):
        np.testing.assert_array_equal(other, published)
