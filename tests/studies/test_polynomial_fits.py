"""The polynomials of damping ratio over restitution."""

import numpy as np
import pytest
import xarray as xr

from rockdamp.equivalence.closed_form import giannini_masiani
from rockdamp.studies import polynomial_fits


def test_fits_keep_to_the_reference_plateau_and_match_numpy(matches, config):
    fit = polynomial_fits.fit(config, matches["cracked_stiffness"])
    assert fit["yield_displacement_ratio"].values.tolist() == [0.02, 0.04, 0.10]
    e = fit["restitution"].values
    one = fit.sel(damping_model="SDR", yield_displacement_ratio=0.04)
    expected = np.polyfit(e, one["damping_ratio"].values, 2)
    np.testing.assert_allclose(one["coefficient"], expected[::-1], rtol=1e-8)
    np.testing.assert_allclose(fit["giannini_masiani"], giannini_masiani(e))
    residual = np.abs(one["damping_ratio"] - one["damping_ratio_fit"])
    assert float(one["largest_residual"]) == pytest.approx(float(residual.max()))
    correlation = np.corrcoef(one["damping_ratio"], one["damping_ratio_fit"])[0, 1]
    assert float(one["r_squared"]) == pytest.approx(correlation**2, rel=1e-9)


def with_ratio(match, values):
    return match.assign(damping_ratio=values.broadcast_like(match["damping_ratio"]))


def test_the_fit_in_delta_is_that_of_the_least_relative_error_and_vanishes_without_loss(
    matches, config
):
    match = matches["cracked_stiffness"]
    fit = polynomial_fits.fit(config, match)
    one = fit.sel(damping_model="CDC", yield_displacement_ratio=0.02)
    delta = -np.log(one["restitution"].values)
    expected = np.polyfit(delta, one["damping_ratio"].values / delta, 2)
    np.testing.assert_allclose(one["delta_coefficient"], expected[::-1], rtol=1e-8)
    np.testing.assert_allclose(
        one["damping_ratio_delta_fit"], delta * np.polyval(expected, delta), rtol=1e-10
    )
    # With one e more, at which nothing is lost, both are what they were, and zero there.
    lossless = xr.concat(
        [match, match.isel(restitution=[-1]).assign_coords(restitution=[1.0])], "restitution"
    )
    lossless["damping_ratio"] = lossless["damping_ratio"].where(lossless["restitution"] < 1, 0.0)
    again = polynomial_fits.fit(config, lossless)
    np.testing.assert_allclose(again["delta_coefficient"], fit["delta_coefficient"], rtol=1e-8)
    assert (again["damping_ratio_delta_fit"].sel(restitution=1.0) == 0).all()
    assert np.isfinite(again["delta_largest_relative_error"].isel(restitution_range=-1)).all()


def test_relative_errors_are_those_of_each_range_of_e(matches, config):
    """A ratio that both fits hit, but for one e of each range, at which it is off by a known part."""
    e = xr.DataArray(np.array([0.7, 0.8, 0.9, 0.93, 0.96, 0.98]), dims="restitution")
    match = matches["cracked_stiffness"].interp(restitution=e, kwargs={"fill_value": "extrapolate"})
    fit = polynomial_fits.fit(
        config,
        with_ratio(
            match.assign_coords(restitution=e), 0.3 - 0.4 * e + 0.1 * e**2 + 0.01 * (e == 0.98)
        ),
    )
    for fitted, error in (
        ("damping_ratio_fit", "largest_relative_error"),
        ("damping_ratio_delta_fit", "delta_largest_relative_error"),
    ):
        apart = np.abs(fit[fitted] / fit["damping_ratio"] - 1)
        for end, own in ((0.90, [0.7, 0.8, 0.9]), (0.96, [0.93, 0.96]), (1.00, [0.98])):
            expected = apart.sel(restitution=own).max("restitution")
            np.testing.assert_array_equal(fit[error].sel(restitution_range=end), expected)


def test_the_table_of_coefficients_holds_every_polynomial_once(matches, config):
    fit = polynomial_fits.fit(config, matches["cracked_stiffness"])
    table = polynomial_fits.table(fit)
    assert len(table) == fit.sizes["damping_model"] * fit.sizes["yield_displacement_ratio"]
    row = table[(table.damping_model == "CDR") & (table.yield_displacement_ratio == 0.10)].iloc[0]
    own = fit["coefficient"].sel(damping_model="CDR", yield_displacement_ratio=0.10).values
    assert [row.c0, row.c1, row.c2] == own.tolist()
    own = fit.sel(damping_model="CDR", yield_displacement_ratio=0.10)
    assert [row.d0, row.d1, row.d2] == own["delta_coefficient"].values.tolist()
    assert row["delta_largest_relative_error_to_0.96"] == own["delta_largest_relative_error"].sel(
        restitution_range=0.96
    )
