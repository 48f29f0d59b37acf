"""The polynomials of damping ratio over restitution."""

import numpy as np
import pytest

from rockdamp.equivalence.closed_form import giannini_masiani
from rockdamp.studies import polynomial_fits


def test_a_quadratic_is_fitted_exactly(matches, config):
    match = matches["cracked_stiffness"].copy(deep=True)
    e = match["restitution"]
    match["damping_ratio"] = (0.3 - 0.4 * e + 0.1 * e**2).broadcast_like(match["damping_ratio"])
    fit = polynomial_fits.fit(config, match)
    np.testing.assert_allclose(fit["coefficient"], np.broadcast_to([0.3, -0.4, 0.1], fit["coefficient"].shape))
    np.testing.assert_allclose(fit["largest_residual"], 0, atol=1e-14)


def test_fits_keep_to_the_reference_plateau_and_match_numpy(matches, config):
    fit = polynomial_fits.fit(config, matches["cracked_stiffness"])
    assert fit["cracked_stiffness_ratio"].values.tolist() == [0.02, 0.04, 0.10]
    e = fit["restitution"].values
    one = fit.sel(damping_model="SDR", cracked_stiffness_ratio=0.04)
    expected, covariance = np.polyfit(e, one["damping_ratio"].values, 2, cov=True)
    np.testing.assert_allclose(one["coefficient"], expected[::-1], rtol=1e-8)
    np.testing.assert_allclose(one["coefficient_covariance"], covariance[::-1, ::-1], rtol=1e-6)
    np.testing.assert_allclose(fit["giannini_masiani"], giannini_masiani(e))
    residual = np.abs(one["damping_ratio"] - one["damping_ratio_fit"])
    assert float(one["largest_residual"]) == pytest.approx(float(residual.max()))


def test_the_table_of_coefficients_holds_every_polynomial_once(matches, config):
    fit = polynomial_fits.fit(config, matches["cracked_stiffness"])
    table = polynomial_fits.table(fit)
    assert len(table) == fit.sizes["damping_model"] * fit.sizes["cracked_stiffness_ratio"]
    row = table[(table.damping_model == "CDR") & (table.cracked_stiffness_ratio == 0.10)].iloc[0]
    own = fit["coefficient"].sel(damping_model="CDR", cracked_stiffness_ratio=0.10).values
    assert [row.c0, row.c1, row.c2] == own.tolist()
