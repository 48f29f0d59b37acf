"""The polynomials of the damping ratio in the restitution coefficient."""

import numpy as np
import pytest
import xarray as xr

from rockdamp.equivalence.closed_form import giannini_masiani
from rockdamp.studies import polynomial_fits


@pytest.fixture(scope="module")
def matched(matches):
    return matches["cracked_stiffness"]


@pytest.fixture(scope="module")
def fit(config, matched):
    return polynomial_fits.fit(config, matched)


# --- polynomials of the paper ---------------------------------------------------------------------


@pytest.fixture(scope="module")
def sdr(fit):
    return fit.sel(damping_model="SDR", yield_displacement_ratio=0.04)


def test_only_curves_of_the_reference_plateau_are_fitted(fit):
    assert fit["yield_displacement_ratio"].values.tolist() == [0.02, 0.04, 0.10]


def test_coefficients_are_those_of_numpy(sdr):
    expected = np.polyfit(sdr["restitution"].values, sdr["damping_ratio"].values, 2)
    np.testing.assert_allclose(sdr["coefficient"], expected[::-1], rtol=1e-8)


def test_giannini_and_masiani_are_tabulated(fit):
    expected = giannini_masiani(fit["restitution"].values)
    np.testing.assert_allclose(fit["giannini_masiani"], expected)


def test_largest_residual_is_that_of_the_fit(sdr):
    residual = np.abs(sdr["damping_ratio"] - sdr["damping_ratio_fit"])
    assert float(sdr["largest_residual"]) == pytest.approx(float(residual.max()))


def test_r_squared_is_the_squared_correlation(sdr):
    correlation = np.corrcoef(sdr["damping_ratio"], sdr["damping_ratio_fit"])[0, 1]
    assert float(sdr["r_squared"]) == pytest.approx(correlation**2, rel=1e-9)


# --- polynomials that vanish without loss ---------------------------------------------------------


def test_delta_fit_has_the_least_relative_error(fit):
    cdc = fit.sel(damping_model="CDC", yield_displacement_ratio=0.02)
    delta = -np.log(cdc["restitution"].values)
    expected = np.polyfit(delta, cdc["damping_ratio"].values / delta, 2)
    np.testing.assert_allclose(cdc["delta_coefficient"], expected[::-1], rtol=1e-8)
    fitted = delta * np.polyval(expected, delta)
    np.testing.assert_allclose(cdc["damping_ratio_delta_fit"], fitted, rtol=1e-10)


@pytest.fixture(scope="module")
def lossless_fit(config, matched):
    """A fit with one e more, e = 1, at which nothing is lost."""
    last = matched.isel(restitution=[-1]).assign_coords(restitution=[1.0])
    lossless = xr.concat([matched, last], "restitution")
    ratio = lossless["damping_ratio"].where(lossless["restitution"] < 1, 0.0)
    return polynomial_fits.fit(config, lossless.assign(damping_ratio=ratio))


def test_delta_fit_vanishes_without_loss(lossless_fit):
    assert (lossless_fit["damping_ratio_delta_fit"].sel(restitution=1.0) == 0).all()


def test_value_without_loss_decides_nothing(fit, lossless_fit):
    coefficient = lossless_fit["delta_coefficient"]
    np.testing.assert_allclose(coefficient, fit["delta_coefficient"], rtol=1e-8)


def test_relative_error_leaves_out_the_value_without_loss(lossless_fit):
    error = lossless_fit["delta_largest_relative_error"].isel(restitution_range=-1)
    assert np.isfinite(error).all()


# --- errors and table -----------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("fitted", "error"),
    [
        ("damping_ratio_fit", "largest_relative_error"),
        ("damping_ratio_delta_fit", "delta_largest_relative_error"),
    ],
)
@pytest.mark.parametrize(
    ("end", "members"), [(0.90, [0.7, 0.8, 0.9]), (0.96, [0.93, 0.96]), (1.00, [0.98])]
)
def test_relative_errors_are_those_of_each_range(config, matched, fitted, error, end, members):
    e = xr.DataArray(np.array([0.7, 0.8, 0.9, 0.93, 0.96, 0.98]), dims="restitution")
    wider = matched.interp(restitution=e, kwargs={"fill_value": "extrapolate"})
    ratio = 0.3 - 0.4 * e + 0.1 * e**2 + 0.01 * (e == 0.98)
    wider = wider.assign(damping_ratio=ratio.broadcast_like(wider["damping_ratio"]))
    fit = polynomial_fits.fit(config, wider.assign_coords(restitution=e))
    relative = np.abs(fit[fitted] / fit["damping_ratio"] - 1)
    expected = relative.sel(restitution=members).max("restitution")
    np.testing.assert_array_equal(fit[error].sel(restitution_range=end), expected)


@pytest.fixture(scope="module")
def table(fit):
    return polynomial_fits.table(fit)


def test_table_has_a_row_for_each_polynomial(fit, table):
    assert len(table) == fit.sizes["damping_model"] * fit.sizes["yield_displacement_ratio"]


def test_table_has_the_coefficients_and_errors(fit, table):
    is_row = (table.damping_model == "CDR") & (table.yield_displacement_ratio == 0.10)
    row = table[is_row].iloc[0]
    polynomial = fit.sel(damping_model="CDR", yield_displacement_ratio=0.10)
    assert [row.c0, row.c1, row.c2] == polynomial["coefficient"].values.tolist()
    assert [row.d0, row.d1, row.d2] == polynomial["delta_coefficient"].values.tolist()
    error = polynomial["delta_largest_relative_error"].sel(restitution_range=0.96)
    assert row["delta_largest_relative_error_to_0.96"] == error
