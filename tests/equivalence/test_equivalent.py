"""The equivalence for one wall in Python, the polynomials beside it, and what a program asks for."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from configs import changed, configured

import rockdamp as rd
from rockdamp.constants import DEFAULT_RESPONSE_LENGTH, VISCOUS_MODELS
from rockdamp.equivalence import polynomials, programs
from rockdamp.equivalence.equivalent import equivalent_restitution
from rockdamp.equivalence.polynomials import (
    SHIPPED_STRENGTH_RATIO,
    Polynomials,
    shipped_polynomials,
)
from rockdamp.studies import polynomial_fits
from rockdamp.studies.decays import study
from rockdamp.studies.matches import match

CURVE = rd.TrilinearCurve(0.04, 0.85)
SHIPPED = pd.read_csv(Path(polynomials.__file__).with_name("coefficients.csv"))


def test_each_viscous_model_has_a_row_whose_fit_is_within_the_largest_residual():
    rows = rd.equivalent([0.9, 0.8], CURVE)
    assert [(row["restitution"], row["damping_model"]) for row in rows] == [
        (e, model) for e in (0.8, 0.9) for model in VISCOUS_MODELS
    ]
    assert rows[len(VISCOUS_MODELS) :] == rd.equivalent(0.9, CURVE)
    residual = SHIPPED[SHIPPED["yield_displacement_ratio"] == 0.04].set_index("damping_model")[
        "largest_residual"
    ]
    for row in rows:
        limit = residual[row["damping_model"]] + 2e-3 * row["damping_ratio"]
        assert abs(row["damping_ratio_fit"] - row["damping_ratio"]) <= limit
        assert 0 < row["rms_error"] < 0.05


def test_without_loss_every_ratio_is_zero_beyond_the_fits_there_is_none_and_a_stiff_curve_s_step_resolves_the_band():
    band = rd.equivalent(0.9, rd.TrilinearCurve(1e-4, 0.8))[-1]
    assert band["damping_model"] == "BAND" and band["damping_ratio"] == pytest.approx(
        -np.log(0.9) / np.pi, rel=0.02
    )
    for row in rd.equivalent(1.0, CURVE):
        assert row["damping_ratio"] == row["rms_error"] == row["damping_ratio_energy"] == 0.0
        assert row["damping_ratio_fit"] is None


def test_the_decay_that_is_matched_starts_where_it_is_asked_to():
    """From far out CDC needs less than on the first branch, by as much as the closed form says, to a fifth."""
    curve = rd.TrilinearCurve(0.2, 0.6)
    for release in (0.15, 0.9):
        cdc = rd.equivalent(0.9, curve, release_amplitude=release)[0]
        energy = rd.damping_ratio_energy(curve, "CDC", 0.9, release).item()
        assert cdc["damping_ratio_energy"] == energy
        assert cdc["damping_ratio"] == pytest.approx(energy, rel=0.2)


BAD = [
    ("restitution", 1.2),
    ("release_amplitude", 1.0),
    ("response_length", 0.1),
    ("response_length", -1.0),
]


@pytest.mark.parametrize(("name", "value"), BAD)
def test_what_is_outside_its_range_is_named(name, value):
    with pytest.raises(rd.InputError, match=name):
        rd.equivalent(**{"restitution": 0.85, "curve": CURVE, name: value})


def test_the_restitution_of_a_damping_ratio_is_that_which_it_stands_for():
    ratio = {row["damping_model"]: row["damping_ratio"] for row in rd.equivalent(0.85, CURVE)}[
        "CDR"
    ]
    found = {
        row["damping_model"]: row["restitution"] for row in equivalent_restitution(ratio, CURVE)
    }
    assert found["CDR"] == pytest.approx(0.85, abs=1e-9)
    assert {row["restitution"] for row in equivalent_restitution(0.9, CURVE)} == {None}


# --- polynomials ------------------------------------------------------------------------------------------------------


def test_polynomials_of_a_dataset_are_linear_in_a1_and_nan_beyond_their_range():
    coords = {
        "damping_model": ["SDR", "CDR"],
        "yield_displacement_ratio": [0.06, 0.02, 0.04],
        "degree": [0, 1, 2],
    }
    numbers = xr.DataArray(np.arange(18.0).reshape(2, 3, 3), coords)
    built = xr.Dataset({"coefficient": numbers}, {"restitution": [0.7, 0.8, 0.9]})
    e, fits = np.array([[0.7, 0.75], [0.8, 0.9]]), Polynomials.from_dataset(built)
    np.testing.assert_allclose(fits("SDR", e, 0.06), 0.0 + 1.0 * e + 2.0 * e**2, rtol=1e-15)
    ends = [fits("CDR", e, a1) for a1 in (0.02, 0.04)]
    np.testing.assert_allclose(ends[0], 12.0 + 13.0 * e + 14.0 * e**2, rtol=1e-15)
    np.testing.assert_allclose(
        Polynomials.from_dataset(built.transpose())("CDR", e, 0.03), np.mean(ends, axis=0)
    )
    assert np.isnan(fits("SDR", [0.69, 0.7, 0.9, 0.91], 0.03)).tolist() == [
        True,
        False,
        False,
        True,
    ]
    assert np.isnan(
        [fits("SDR", 0.8, 0.019), fits("SDR", 0.8, 0.061), fits("ECD", 0.8, 0.04)]
    ).all()


def test_the_shipped_coefficients_are_what_the_pipeline_builds():
    config = changed(configured(), {"response_lengths.stop": DEFAULT_RESPONSE_LENGTH})
    assert config.curve.strength_ratio == SHIPPED_STRENGTH_RATIO
    fitted = polynomial_fits.fit(
        config, match("cracked_stiffness", config, study("cracked_stiffness", config))
    )
    built, shipped, e = (
        Polynomials.from_dataset(fitted),
        shipped_polynomials(),
        np.linspace(0.7, 0.98, 15),
    )
    assert list(built.coefficient) == list(shipped.coefficient) == list(VISCOUS_MODELS)
    np.testing.assert_array_equal(built.yield_displacement_ratio, shipped.yield_displacement_ratio)
    for model in VISCOUS_MODELS:
        for a1 in shipped.yield_displacement_ratio:  # other vector units round otherwise
            np.testing.assert_allclose(shipped(model, e, a1), built(model, e, a1), atol=1e-5)


# --- programs ---------------------------------------------------------------------------------------------------------


def test_a_dashpot_damps_the_first_branch_by_its_ratio_and_none_stands_for_a_coefficient_that_changes():
    """C is twice the ratio times the root of stiffness and mass, both in physical units."""
    wall = rd.Wall(thickness=0.3, height=4.5, overburden_ratio=2.0)
    found = programs.describe_damping(wall, CURVE, 0.85)
    rows = {row["damping_model"]: row for row in found["damping"]}
    assert list(rows) == list(VISCOUS_MODELS)
    stiffness = CURVE.strength_ratio * wall.rigid_strength / (0.04 * wall.instability_displacement)
    expected = 2 * rows["CDC"]["damping_ratio"] * np.sqrt(stiffness * wall.effective_mass)
    assert rows["CDC"]["damping_coefficient"] == pytest.approx(float(expected))
    assert found["rayleigh_alpha_m"] == pytest.approx(float(expected / wall.effective_mass))
    assert all(row["damping_coefficient"] is None for model, row in rows.items() if model != "CDC")
    assert {row["missed_collapse_rate"] for row in rows.values()} == set(
        programs.missed_collapses(0.85)[1].values()
    )


def test_a_curve_that_no_damping_ratio_matches_has_the_closed_form_s(monkeypatch):
    def refuse(*arguments, **named):
        raise rd.InputError("no minimum within reach")

    monkeypatch.setattr(programs, "equivalent", refuse)
    for row in programs.describe_damping(rd.Wall(thickness=0.3, height=4.5), CURVE, 0.85)[
        "damping"
    ]:
        energy = rd.damping_ratio_energy(CURVE, row["damping_model"], 0.85, 0.5).item()
        assert (row["damping_ratio"], row["rms_error"], row["damping_ratio_energy"]) == (
            energy,
            None,
            energy,
        )
