"""The picture of a wall's fragility: its curve, stripes and interval are those of the assessment."""

import numpy as np
import pytest
import xarray as xr
from scipy.stats import norm

from rockdamp.figures.single import fragility_figure


def made_up(measure="pgv", median=(0.5, np.nan)):
    stripes = np.geomspace(0.1, 5.0, 16)
    counts = np.stack([np.linspace(0, 40, 16).astype(int), np.linspace(0, 30, 16).astype(int)])
    by_model, at = ("damping_model",), ("damping_model", "intensity")
    return xr.Dataset(
        {
            measure: ("intensity", [0.3, 0.6]),
            f"stripe_{measure}": ("stripe", stripes),
            "stripe_collapses": ((*by_model, "stripe"), counts),
            f"median_{measure}": (by_model, list(median)),
            "dispersion": (by_model, [0.4, np.nan]),
            "collapse_probability": (at, [[0.25, 0.5], [0.2, 0.4]]),
            "collapse_probability_interval": ((*at, "bound"), [[[0.1, 0.4], [0.3, 0.7]], [[0.1, 0.3], [0.2, 0.6]]]),
            "records": 40,
        },
        coords={"damping_model": ["CR", "BAND"]},
        attrs={"intensity_measure": measure.upper()},
    )


@pytest.mark.parametrize("measure", ["pgv", "pga"])
def test_curve_stripes_and_interval_are_drawn(measure):
    answer = made_up(measure)
    figure = fragility_figure(answer)
    figure.draw_without_rendering()
    (axes,) = figure.axes
    by_label = {str(line.get_label()): line for line in axes.get_lines()}
    (curve,) = (line for label, line in by_label.items() if label.startswith("CR: median 0.5"))
    level = curve.get_xdata()
    np.testing.assert_allclose(curve.get_ydata(), norm.cdf(np.log(level / 0.5) / 0.4), rtol=1e-12)
    assert "BAND: no lognormal curve" in by_label
    drawn = [line.get_ydata() for line in axes.get_lines() if len(line.get_xdata()) == 16]
    np.testing.assert_allclose(drawn, answer["stripe_collapses"] / 40)
    (bars,) = axes.collections
    spans = sorted(segment[:, 1].tolist() for segment in bars.get_segments())
    np.testing.assert_allclose(spans, [[0.1, 0.4], [0.3, 0.7]])
    assert measure.upper() in axes.get_xlabel() and "40 records" in axes.get_ylabel()
