"""From viscous to impact: what the figure shows is what was measured."""

import numpy as np
from figure_reading import drawn, labelled, panel_titled, shows
from report_content import of_name

from rockdamp.figures.damper_order import at_middle, at_shown, fig_order_caption


def test_fig_order_shows_each_error_against_the_order_and_the_band_of_restitution_itself():
    figure, by_order, earthquakes = (
        drawn("fig_order"),
        of_name("damper_order"),
        at_middle(of_name("earthquakes/orders")),
    )
    at_e = at_shown(by_order)
    own_earthquakes = earthquakes["varied_log_error"].sel(variation=["lower e", "higher e"])
    panels = {
        "(a)": (at_e["rms_error"], at_e["varied_rms_error"]),
        "(b)": (earthquakes["log_error"], own_earthquakes),
    }
    for title, (error, own) in panels.items():
        axes = panel_titled(figure, title)
        places = np.arange(error.size)
        assert shows(axes, places, error.values)
        assert [text.get_text() for text in axes.get_xticklabels()] == [f"{m:g}" for m in error["order"].values]
        band = axes.patches[0].get_extents().transformed(axes.transData.inverted())
        np.testing.assert_allclose([band.y0, band.y1], [own.min(), own.max()])


def test_fig_order_shows_the_damping_force_and_the_velocity_of_the_orders_beside_the_impact():
    figure, by_order = drawn("fig_order"), of_name("damper_order")
    force, velocity = (panel_titled(figure, title) for title in ("(c)", "(d)"))
    for m in (0, 1):
        of_order = by_order.sel(order=m)
        line = labelled(force, f"$m = {m}$")
        shown = np.size(line.get_xdata())
        np.testing.assert_array_equal(line.get_xdata(), of_order["shown_displacement"][:shown])
        np.testing.assert_array_equal(line.get_ydata(), of_order["shown_damping_force"][:shown])
        later = of_order["shown_velocity"].values[-labelled(velocity, f"$m = {m}$").get_xdata().size :]
        np.testing.assert_array_equal(labelled(velocity, f"$m = {m}$").get_ydata(), later)
    assert set(labelled(force, "impact").get_xdata()) == {0}


def test_the_caption_tells_the_largest_difference_of_the_peaks_over_every_e_and_order():
    by_order, earthquakes = of_name("damper_order"), of_name("earthquakes/orders")
    by_order = by_order.assign(peak_error=by_order["peak_error"] * 0 + 0.001)
    by_order["peak_error"][-1, 0] = 0.0123  # not at the shown e
    assert "differ from those under CR by 1.3 % at most" in " ".join(fig_order_caption(by_order, earthquakes).split())
