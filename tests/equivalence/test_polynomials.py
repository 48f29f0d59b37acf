"""Evaluating xi(e) by the polynomials: those that the package ships, and those of a dataset."""

import numpy as np
import pytest
import xarray as xr
from configs import changed, configured

from rockdamp.equivalence.polynomials import SHIPPED_STRENGTH_RATIO, Polynomials, shipped, shipped_coefficients
from rockdamp.errors import InputError
from rockdamp.studies import polynomial_fits
from rockdamp.studies.decays import study
from rockdamp.studies.matches import match
from rockdamp.vocabulary import DEFAULT_RESPONSE_LENGTH


@pytest.fixture(scope="module")
def built():
    """Polynomials of two models at three a1, in no order."""
    coefficient = np.arange(18.0).reshape(2, 3, 3)
    return xr.Dataset(
        {"coefficient": (("damping_model", "yield_displacement_ratio", "degree"), coefficient)},
        coords={
            "damping_model": ["SDR", "CDR"],
            "yield_displacement_ratio": [0.06, 0.02, 0.04],
            "degree": [0, 1, 2],
            "restitution": [0.7, 0.8, 0.9],
        },
    )


def test_at_a_fit_the_polynomial_is_that_of_its_coefficients(built):
    e = np.array([[0.7, 0.75], [0.8, 0.9]])
    of = Polynomials.from_dataset(built)
    np.testing.assert_allclose(of("SDR", e, 0.06), 0.0 + 1.0 * e + 2.0 * e**2, rtol=1e-15)
    np.testing.assert_allclose(of("CDR", e, 0.02), 12.0 + 13.0 * e + 14.0 * e**2, rtol=1e-15)
    np.testing.assert_array_equal(Polynomials.from_dataset(built.transpose())("CDR", e, 0.03), of("CDR", e, 0.03))


def test_polynomials_are_linear_in_the_cracked_stiffness_between_the_fits():
    between = shipped()("CDR", 0.85, 0.05)
    ends = [shipped()("CDR", 0.85, a1) for a1 in (0.04, 0.06)]
    assert float(between) == pytest.approx(float(np.mean(ends)), rel=1e-12)


def test_there_is_nothing_outside_the_range_of_the_fits_nor_for_a_model_without_any(built):
    of = Polynomials.from_dataset(built)
    assert np.isnan(of("SDR", [0.69, 0.7, 0.9, 0.91], 0.03)).tolist() == [True, False, False, True]
    assert np.isnan(of("SDR", 0.8, 0.019)) and np.isnan(of("SDR", 0.8, 0.061))
    assert np.isnan(of("ECD", [0.7, 0.8], 0.04)).all()


def test_a_range_that_must_hold_is_named_with_the_value_outside_it(built):
    of = Polynomials.from_dataset(built)
    of.require_cover(0.7, [0.02, 0.06], "a1")
    with pytest.raises(InputError, match="restitution is 0.95; it must be within the range of the fits, 0.7 to 0.9"):
        of.require_cover(0.95, 0.04, "a1")
    with pytest.raises(InputError, match="a1 is 0.3; it must be within the range of the fits, 0.02 to 0.06"):
        of.require_cover(0.8, [0.02, 0.3], "a1")


def test_shipped_coefficients_are_what_the_pipeline_builds():
    config = changed(configured(), {"response_lengths.stop": DEFAULT_RESPONSE_LENGTH})
    assert config.curve.strength_ratio == SHIPPED_STRENGTH_RATIO
    decays = study("cracked_stiffness", config)
    built = polynomial_fits.table(polynomial_fits.fit(config, match("cracked_stiffness", config, decays)))
    shipped = shipped_coefficients()
    built = built[built["damping_model"].isin(shipped["damping_model"])].reset_index(drop=True)
    assert list(built["damping_model"]) == list(shipped["damping_model"])
    np.testing.assert_array_equal(built["yield_displacement_ratio"], shipped["yield_displacement_ratio"])
    e = np.linspace(0.7, 0.98, 15)
    for k, row in built.iterrows():
        ours = row.c0 + row.c1 * e + row.c2 * e**2
        theirs = sum(shipped[f"c{n}"][k] * e**n for n in range(3))
        np.testing.assert_allclose(theirs, ours, atol=1e-5)  # other vector units round otherwise
