"""From viscous to impact: what the figure shows is what was measured."""

import numpy as np
from figure_reading import drawn, labelled, panel_titled, shows
from report_content import of_name

from rockdamp.figures.damper_order import at_middle, at_shown, fig_order_caption
from rockdamp.text import plain


def test_fig_order_shows_each_error_against_the_order_and_the_band_of_restitution_itself():
    figure, by_order, earthquakes = (
        drawn("fig_order"),
        of_name("damper_order"),
        at_middle(of_name("earthquakes/orders")),
    )
    at_e = at_shown(by_order)
    own_earthquakes = earthquakes["varied_log_error"].sel(variation=["lower e", "higher e"])
    panels = {
        "(a)": (at_e["curve_rms_error"], at_e["varied_curve_rms_error"]),
        "(b)": (at_e["pulse_log_error"], at_e["varied_pulse_log_error"]),
        "(c)": (earthquakes["log_error"], own_earthquakes),
    }
    for title, (error, own) in panels.items():
        axes = panel_titled(figure, title)
        places = np.arange(error.size)
        assert shows(axes, places, error.values)
        assert [text.get_text() for text in axes.get_xticklabels()] == [f"{m:g}" for m in error["order"].values]
        band = axes.patches[0].get_extents().transformed(axes.transData.inverted())
        np.testing.assert_allclose([band.y0, band.y1], [own.min(), own.max()])
    assert shows(panel_titled(figure, "(b)"), places, at_e["pulse_before_impact_log_error"].values)
    for model in at_e["damping_model"].values:
        line = labelled(panel_titled(figure, "(a)"), f"{model}, fitted")
        assert set(line.get_ydata()) == {float(at_e["fitted_rms_error"].sel(damping_model=model))}


def test_fig_order_shows_the_damping_force_and_the_velocity_of_the_orders_beside_the_impact():
    figure, by_order = drawn("fig_order"), of_name("damper_order")
    force, velocity = (panel_titled(figure, title) for title in ("(d)", "(e)"))
    for m in (0, 1):
        of_order = by_order.sel(order=m)
        line = labelled(force, f"$m = {m}$")
        shown = np.size(line.get_xdata())
        np.testing.assert_array_equal(line.get_xdata(), of_order["shown_displacement"][:shown])
        np.testing.assert_array_equal(line.get_ydata(), of_order["shown_damping_force"][:shown])
        later = of_order["shown_velocity"].values[-labelled(velocity, f"$m = {m}$").get_xdata().size :]
        np.testing.assert_array_equal(labelled(velocity, f"$m = {m}$").get_ydata(), later)
    assert set(labelled(force, "impact").get_xdata()) == {0}


def test_the_caption_tells_the_largest_difference_of_the_peaks_over_every_e_curve_and_order():
    by_order, earthquakes = of_name("damper_order"), of_name("earthquakes/orders")
    by_order = by_order.assign({name: by_order[name] * 0 + 0.001 for name in ("peak_error", "curve_peak_error")})
    by_order["peak_error"][-1, 0, 0, 0] = 0.0123  # not at the shown e
    assert "differ from those under CR by 1.3 % at most" in " ".join(fig_order_caption(by_order, earthquakes).split())


def test_the_caption_holds_an_order_against_the_smaller_side_of_the_change_of_e_under_pulses():
    by_order, earthquakes = of_name("damper_order"), of_name("earthquakes/orders")
    error = by_order["pulse_log_error"] * 0 + [[0.3], [0.15], [0.1]][: by_order.sizes["order"]]
    varied = by_order["varied_pulse_log_error"] * 0 + 0.2
    varied[0] = 0.1
    made = by_order.assign(pulse_log_error=error, varied_pulse_log_error=varied)
    text = " ".join(fig_order_caption(made, earthquakes).split())
    assert f"below the grey band at m&nbsp;=&nbsp;{plain(by_order['order'][2])}, the largest studied." in text
    none = by_order.assign(pulse_log_error=error + 1.0, varied_pulse_log_error=varied)
    assert "below the grey band at no order studied." in " ".join(fig_order_caption(none, earthquakes).split())
