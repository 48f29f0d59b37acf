"""Walls under records with a loss that falls with the amplitude: against the event-driven law, and what is refused."""

import numpy as np
import pytest

import rockdamp as rd
from rockdamp.assessment.answers import columns, lines
from rockdamp.assessment.assess import assess_rows
from rockdamp.assessment.table import Row
from rockdamp.motions.record import append_rest
from rockdamp.solvers.exact import exact_history
from rockdamp.storage import dataset

LAW = {"exponent": 0.26, "at": 0.1}


def test_the_peak_is_that_of_the_law_solved_event_by_event(wall, curve, motions):
    """Where the constant e lets the wall collapse."""
    motion, p = motions[3], float(wall.frequency_parameter)
    asked = {"pga": 4.2, "restitution": 0.85, "step": 0.005}
    found = rd.assess(wall, curve, motion, **asked, **LAW).sel(damping_model="CR")
    ground = append_rest(motion.record.ground_acceleration, motion.record.step, 3.0)
    exact = exact_history(
        curve,
        rd.Damping("CR", 0.85, loss_exponent=LAW["exponent"], reference_amplitude=LAW["at"]),
        p * motion.record.step * np.arange(1, ground.size),
        load=float(wall.load_factor) * found["scale_factor"].item() * ground,
        sampling=p * motion.record.step,
    )
    assert found["peak"].item() == pytest.approx(np.abs(exact.displacement).max(), rel=1e-3)
    assert np.isnan(rd.assess(wall, curve, motion, **asked)["peak"].sel(damping_model="CR").item())


def test_the_answer_says_its_law_and_without_an_exponent_nothing_changes(wall, curve, motions, answer):
    same = rd.assess(wall, curve, motions, pgv=[0.4, 0.8], restitution=0.85, exponent=0.0, at=0.1)
    assert same.identical(answer) and "loss_exponent" not in same
    found = rd.assess(wall, curve, motions[:2], pgv=0.8, restitution=0.85, **LAW)
    assert (float(found["loss_exponent"]), float(found["reference_amplitude"])) == (0.26, 0.1)
    dataset.check(found, "assessment")
    damper = found.sel(damping_model="ECD")
    xi = damper["damping_ratio"].item()
    assert damper["order"].item() == 16
    assert xi == pytest.approx((1 - 0.85**0.52) / (2 * np.pi * 0.26), rel=1e-12)  # docs/theory.md, section 8


def test_rows_take_the_law_and_a_row_whose_curve_ends_before_the_amplitude_has_an_error(wall, curve, motions):
    few, short = motions[:2], rd.TrilinearCurve(0.02, 0.85, 0.2)
    rows = [
        Row(2, "one", wall, curve, 0.85),
        Row(3, "two", wall, short, 0.85),
        Row(4, "three", wall, curve, 0.7),
    ]
    found = assess_rows(rows, few, "PGV", 0.8, exponent=0.26, at=0.3)
    dataset.check(found, "batch")
    assert "line 3: reference_amplitude is 0.3" in found["row_error"].values[1]
    for row in (rows[0], rows[2]):
        alone = rd.assess(wall, curve, few, pgv=0.8, restitution=row.restitution, exponent=0.26)
        np.testing.assert_array_equal(found["stripe_collapses"].sel(wall=row.id), alone["stripe_collapses"])
    table = list(lines(found))
    assert columns(found)[-2:] == ("loss_exponent", "reference_amplitude")
    assert [row["loss_exponent"] for row in table if not row["error"]] == [0.26] * 4


def test_the_share_by_rigid_mechanics_takes_the_law(wall, curve, motions):
    few = motions[:3]
    found = rd.assess(wall, curve, few, pgv=0.8, **LAW)
    impulsive = rd.assess(wall, curve, few, pgv=0.8, restitution="impulsive", **LAW)
    np.testing.assert_array_equal(found["collapse_probability_impulsive"], impulsive["collapse_probability"])


@pytest.mark.parametrize(
    ("law", "said"),
    [
        ({"exponent": -0.1}, "exponent"),
        ({"exponent": 0.5}, "exponent"),
        ({"exponent": 0.26, "at": 0.0}, "reference_amplitude"),
        ({"exponent": 0.26, "at": 1.0}, "reference_amplitude"),
    ],
)
def test_a_law_that_is_none_is_named(law, said, wall, curve, motions):
    with pytest.raises(rd.InputError, match=said):
        rd.assess(wall, curve, motions[:1], pgv=0.4, restitution=0.85, **law)


def test_a_wall_against_a_stop_takes_no_exponent(curve, motions):
    front = rd.OneSidedWall(rd.Parapet(0.3, 3.0))
    with pytest.raises(rd.InputError, match="exponent is 0.26; it must be 0 for a wall against a stop"):
        rd.assess(front, curve, motions[:1], pgv=0.4, restitution=0.5, exponent=0.26)
