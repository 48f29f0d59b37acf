"""The picture of least squares: the histories that were fitted, and what they leave."""

import numpy as np
import xarray as xr

from rockdamp.laboratory.figures import calibration_figure


def test_a_calibration_is_drawn_with_what_it_leaves_and_its_errors():
    time = np.linspace(0.0, 2.0, 41)
    names = ["yield_displacement_ratio", "strength_ratio", "restitution"]
    fit = xr.Dataset(
        {
            "measured": ("elapsed", 0.02 * np.cos(time) + 0.001),
            "control_displacement": ("elapsed", 0.02 * np.cos(time)),
            "estimate": ("parameter", [0.03, 0.8, 0.84]),
            "standard_error": ("parameter", [0.001, 0.002, 0.003]),
        },
        coords={"elapsed": time, "parameter": names},
    )
    axes, left = calibration_figure(fit).axes
    np.testing.assert_allclose(left.get_lines()[0].get_ydata(), 1.0)
    assert axes.get_title() == ",  ".join(
        f"${symbol} = {value:.4f} \\pm {error:.4f}$"
        for symbol, value, error in (("a_1", 0.03, 0.001), ("b_1", 0.8, 0.002), ("e", 0.84, 0.003))
    )
