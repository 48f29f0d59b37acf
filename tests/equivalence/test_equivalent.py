"""The equivalence for one wall, the polynomials beside it, and the input of a program."""

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
    Polynomials,
    shipped_polynomials,
)
from rockdamp.studies import polynomial_fits
from rockdamp.studies.decays import decay
from rockdamp.studies.matches import match

CURVE = rd.TrilinearCurve(0.04, 0.85)
SHIPPED = pd.read_csv(Path(polynomials.__file__).with_name("coefficients.csv"))


def by_model(rows, name):
    """Return a column of the rows of one e, by damping model."""
    return {row["damping_model"]: row[name] for row in rows}


def test_rows_are_by_restitution_and_model():
    rows = rd.equivalent([0.9, 0.8], CURVE)
    keys = [(row["restitution"], row["damping_model"]) for row in rows]
    assert keys == [(e, model) for e in (0.8, 0.9) for model in VISCOUS_MODELS]
    assert rows[len(VISCOUS_MODELS) :] == rd.equivalent(0.9, CURVE)


@pytest.mark.parametrize("e", [0.8, 0.9])
def test_fit_is_within_its_largest_residual(e):
    fits = SHIPPED[SHIPPED["yield_displacement_ratio"] == 0.04]
    residual = fits.set_index("damping_model")["largest_residual"]
    for row in rd.equivalent(e, CURVE):
        limit = residual[row["damping_model"]] + 2e-3 * row["damping_ratio"]
        assert abs(row["damping_ratio_fit"] - row["damping_ratio"]) <= limit, row
        assert 0 < row["rms_error"] < 0.05


def test_step_of_a_stiff_curve_resolves_the_band():
    ratios = by_model(rd.equivalent(0.9, rd.TrilinearCurve(1e-4, 0.8)), "damping_ratio")
    assert ratios["BAND"] == pytest.approx(-np.log(0.9) / np.pi, rel=0.02)


def test_without_loss_all_ratios_are_zero():
    for row in rd.equivalent(1.0, CURVE):
        assert row["damping_ratio"] == row["rms_error"] == row["damping_ratio_energy"] == 0.0


def test_beyond_the_range_there_is_no_fit():
    fits = by_model(rd.equivalent(1.0, CURVE), "damping_ratio_fit")
    assert set(fits.values()) == {None}


@pytest.mark.parametrize("release", [0.15, 0.9])
def test_decay_starts_at_the_release(release):
    """From far out CDC needs less than on the first branch, as the closed form says."""
    curve = rd.TrilinearCurve(0.2, 0.6)
    cdc = rd.equivalent(0.9, curve, release_amplitude=release)[0]
    energy = rd.damping_ratio_energy(curve, "CDC", 0.9, release).item()
    assert cdc["damping_ratio_energy"] == energy
    assert cdc["damping_ratio"] == pytest.approx(energy, rel=0.2)


BAD_ARGUMENTS = [
    ("restitution", 1.2),
    ("release_amplitude", 1.0),
    ("response_length", 0.0),
    ("response_length", -1.0),
]


@pytest.mark.parametrize(("name", "value"), BAD_ARGUMENTS)
def test_bad_argument_is_refused_by_name(name, value):
    arguments = {"restitution": 0.85, "curve": CURVE}
    with pytest.raises(rd.InputError, match=name):
        rd.equivalent(**(arguments | {name: value}))


def test_response_before_the_first_impact_is_refused():
    with pytest.raises(rd.InputError, match="response_length.*first impact"):
        rd.equivalent(0.85, CURVE, response_length=0.1)


def test_restitution_of_a_damping_ratio_is_the_inverse():
    ratio = by_model(rd.equivalent(0.85, CURVE), "damping_ratio")["CDR"]
    restitution = by_model(equivalent_restitution(ratio, CURVE), "restitution")
    assert restitution["CDR"] == pytest.approx(0.85, abs=1e-9)


def test_restitution_of_a_ratio_beyond_reach_is_none():
    restitution = by_model(equivalent_restitution(0.9, CURVE), "restitution")
    assert set(restitution.values()) == {None}


# --- polynomials ---------------------------------------------------------------------------------

E = np.array([[0.7, 0.75], [0.8, 0.9]])
BUILT = xr.Dataset(
    {
        "coefficient": xr.DataArray(
            np.arange(18.0).reshape(2, 3, 3),
            {
                "damping_model": ["SDR", "CDR"],
                "yield_displacement_ratio": [0.06, 0.02, 0.04],
                "degree": [0, 1, 2],
            },
        )
    },
    {"restitution": [0.7, 0.8, 0.9]},
)
FITS = Polynomials.from_dataset(BUILT)


def test_polynomials_of_a_dataset():
    np.testing.assert_allclose(FITS("SDR", E, 0.06), 0.0 + 1.0 * E + 2.0 * E**2, rtol=1e-15)
    np.testing.assert_allclose(FITS("CDR", E, 0.02), 12.0 + 13.0 * E + 14.0 * E**2, rtol=1e-15)


def test_polynomials_are_linear_in_a1():
    mean = np.mean([FITS("CDR", E, 0.02), FITS("CDR", E, 0.04)], axis=0)
    np.testing.assert_allclose(FITS("CDR", E, 0.03), mean)


def test_order_of_dimensions_does_not_matter():
    transposed = Polynomials.from_dataset(BUILT.transpose())
    np.testing.assert_array_equal(transposed("CDR", E, 0.03), FITS("CDR", E, 0.03))


def test_polynomials_are_nan_beyond_their_range():
    is_missing = np.isnan(FITS("SDR", [0.69, 0.7, 0.9, 0.91], 0.03))
    assert is_missing.tolist() == [True, False, False, True]
    assert np.isnan(FITS("SDR", 0.8, 0.019))
    assert np.isnan(FITS("SDR", 0.8, 0.061))


def test_model_without_fits_is_nan():
    assert np.isnan(FITS("ECD", 0.8, 0.04))


def test_shipped_coefficients_are_those_of_the_pipeline():
    config = changed(configured(), {"response_lengths.stop": DEFAULT_RESPONSE_LENGTH})
    assert config.curve.strength_ratio == 0.85
    ratios = match("cracked_stiffness", config, decay("cracked_stiffness", config))
    built = Polynomials.from_dataset(polynomial_fits.fit(config, ratios))
    shipped = shipped_polynomials()
    assert list(built.coefficient) == list(shipped.coefficient) == list(VISCOUS_MODELS)
    np.testing.assert_array_equal(built.yield_displacement_ratio, shipped.yield_displacement_ratio)
    e = np.linspace(0.7, 0.98, 15)
    for model in VISCOUS_MODELS:
        for a1 in shipped.yield_displacement_ratio:  # other vector units round otherwise
            np.testing.assert_allclose(shipped(model, e, a1), built(model, e, a1), atol=1e-5)


# --- programs ------------------------------------------------------------------------------------

WALL = rd.Wall(thickness=0.3, height=4.5, overburden_ratio=2.0)


def test_dashpot_damps_the_first_branch_by_its_ratio():
    """C is twice the ratio times the root of stiffness and mass, both in physical units."""
    damping = programs.describe_damping(WALL, CURVE, 0.85)
    force = CURVE.strength_ratio * WALL.rigid_strength
    stiffness = force / (0.04 * WALL.instability_displacement)
    xi = by_model(damping["damping"], "damping_ratio")["CDC"]
    expected = float(2 * xi * np.sqrt(stiffness * WALL.effective_mass))
    coefficients = by_model(damping["damping"], "damping_coefficient")
    assert coefficients.pop("CDC") == pytest.approx(expected)
    assert set(coefficients.values()) == {None}
    assert damping["rayleigh_alpha_m"] == pytest.approx(float(expected / WALL.effective_mass))


def test_ratio_of_band_is_its_closed_form():
    """It is exact; the least error would differ by the tolerance of the search."""
    ratios = by_model(programs.describe_damping(WALL, CURVE, 0.85)["damping"], "damping_ratio")
    assert ratios["BAND"] == pytest.approx(-np.log(0.85) / np.pi, rel=1e-12)


def test_missed_collapses_stand_beside_each_damper():
    damping = programs.describe_damping(WALL, CURVE, 0.85)
    missed = by_model(damping["damping"], "missed_collapse_rate")
    assert missed == {model: programs.missed_collapses(0.85)[1][model] for model in VISCOUS_MODELS}


def test_closed_form_where_no_ratio_has_the_least_error(monkeypatch):
    def refuse(*arguments, **options):
        raise rd.InputError("no minimum within reach")

    monkeypatch.setattr(programs, "equivalent", refuse)
    for row in programs.describe_damping(WALL, CURVE, 0.85)["damping"]:
        energy = rd.damping_ratio_energy(CURVE, row["damping_model"], 0.85, 0.5).item()
        assert row["damping_ratio"] == row["damping_ratio_energy"] == energy
        assert row["rms_error"] is None
