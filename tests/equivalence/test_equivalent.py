"""The equivalence for one wall, in Python."""

import pytest

import rockdamp as rd
from rockdamp.equivalence.polynomials import shipped_coefficients
from rockdamp.vocabulary import VISCOUS_MODELS


def test_a_row_for_each_viscous_model_with_its_keys():
    rows = rd.equivalent(0.85, 0.04, 0.85)
    assert [row["damping_model"] for row in rows] == list(VISCOUS_MODELS)
    assert all(list(row) == list(rd.Equivalent.__annotations__) for row in rows)


def test_polynomial_and_match_agree_within_the_largest_residual():
    table = shipped_coefficients()
    rows = [row for row in rd.equivalent(0.85, 0.04, 0.85) if row["damping_model"] in table["damping_model"]]
    assert len(rows) >= 4
    for row in rows:
        own = (table["damping_model"] == row["damping_model"]) & (table["yield_displacement_ratio"] == 0.04)
        limit = float(table["largest_residual"][own][0]) + 2e-3 * row["damping_ratio"]
        assert abs(row["damping_ratio_fit"] - row["damping_ratio"]) <= limit


@pytest.mark.parametrize("e, a1", [(0.69, 0.04), (0.99, 0.04), (0.85, 0.015), (0.85, 0.15)])
def test_there_is_no_fit_outside_the_range_of_the_polynomials(e, a1):
    b1 = 0.75
    assert all(row["damping_ratio_fit"] is None for row in rd.equivalent(e, a1, b1))


def test_without_loss_every_damping_ratio_is_zero():
    for row in rd.equivalent(1.0, 0.04, 0.85):
        assert row["damping_ratio"] == row["rms_error"] == row["damping_ratio_energy"] == 0.0


def test_several_restitutions_come_in_ascending_order():
    rows = rd.equivalent([0.9, 0.8], 0.04, 0.85)
    count = len(VISCOUS_MODELS)
    assert [row["restitution"] for row in rows] == [0.8] * count + [0.9] * count
    alone = rd.equivalent(0.9, 0.04, 0.85)
    assert rows[count:] == alone


@pytest.mark.filterwarnings("ignore:release_amplitude is 0.15 of u_ins")
def test_the_decay_that_is_matched_starts_where_it_is_asked_to():
    """From far out CDC needs less than on the first branch, by as much as the closed form says, to a fifth."""
    curve = rd.TrilinearCurve(0.2, 0.6)
    for release in (0.15, 0.9):
        cdc = rd.equivalent(0.9, 0.2, 0.6, release_amplitude=release)[0]
        energy = float(rd.damping_ratio_energy(curve, "CDC", 0.9, release))
        assert cdc["damping_ratio_energy"] == pytest.approx(energy, rel=1e-12)
        assert cdc["damping_ratio"] == pytest.approx(energy, rel=0.2)


@pytest.mark.parametrize(
    "arguments, named",
    [
        ((1.2, 0.04, 0.85), r"restitution \(e\) is 1.2"),
        ((0.85, 0.3, 0.85), r"yield_displacement_ratio is 0.3"),
        ((0.85, 0.04, 0.85, 0.5, "translated"), r"ultimate_displacement_ratio is 0.5"),
        ((0.85, 0.04, 0.85, 1.0, "steeper", 1.0), "release_amplitude is 1.0"),
        ((0.85, 0.04, 0.85, 1.0, "steeper", 0.5, 0.1), "response_length is 0.1"),
        ((0.85, 0.04, 0.85, 1.0, "steeper", 0.5, -1.0), "response_length is -1.0"),
    ],
)
def test_bad_input_is_named_with_what_is_allowed(arguments, named):
    with pytest.raises(rd.InputError, match=named):
        rd.equivalent(*arguments)


def test_the_equivalent_dampings_are_those_of_the_rows():
    dampings = rd.equivalent_dampings(0.85, rd.TrilinearCurve(0.04, 0.85))
    rows = rd.equivalent(0.85, 0.04, 0.85)
    assert [damping.model for damping in dampings] == ["CR", *(row["damping_model"] for row in rows)]
    assert float(dampings[0].restitution) == 0.85
    assert [float(damping.damping_ratio) for damping in dampings[1:]] == [row["damping_ratio"] for row in rows]


def test_a_response_too_long_to_compute_is_refused():
    with pytest.raises(
        rd.InputError, match=r"response_length is 1e\+09, which takes .* with 1 values of e and a1 = 0.04"
    ):
        rd.equivalent(0.85, 0.04, 0.85, response_length=1e9)
