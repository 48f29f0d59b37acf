"""The explorer's sliders, numbers, presets and address: what they change, and what they refuse."""

import numpy as np
import pytest
from report_browser import (
    PATIENCE,
    PLOTS,
    WebDriverWait,
    complaints,
    message,
    open_page,
    picture,
    preset,
    put,
    ratios,
    shown,
    soften,
    value,
)

from rockdamp.report.interactive import CONTROLS
from rockdamp.vocabulary import PRESETS


@pytest.mark.peers
@pytest.mark.parametrize(
    ("name", "value", "plots"),
    [
        ("a1", 0.12, PLOTS),
        ("b1", 0.6, PLOTS),
        ("a3", 0.8, PLOTS),
        ("e", 0.9, ("plot-laws", "plot-ratios", "plot-decays")),
        ("x0", 0.9, PLOTS),
        ("m", 7, ("plot-laws", "plot-decays")),
        ("t", 0.5, ("plot-decays",)),
        ("h", 9.0, ("plot-decays",)),
    ],
)
def test_a_slider_changes_the_plots_that_depend_on_it(browser, name, value, plots):
    preset(browser, "study")
    put(browser, "e", 0.85)
    put(browser, "x0", 0.5)
    before = {plot: picture(browser, plot) for plot in plots}
    put(browser, name, value, "slider")
    for plot in plots:
        assert picture(browser, plot) != before[plot], plot


@pytest.mark.peers
@pytest.mark.parametrize(
    ("softening", "name", "wanted", "kept", "allowed"),
    [
        ("steeper", "b1", "0.97", 0.95, "b1 is 0.97; it must be greater than 1 − a3 and less than 1 − a1"),
        ("translated", "a3", "0.8", 0.9, "a3 is 0.8; it must be greater than a1 + b1 with translated softening"),
        ("steeper", "e", "1.2", 1.0, "e is 1.2; it must be greater than 0 and at most 1"),
        ("steeper", "a1", "", 0.04, "a1 must be a number"),
    ],
)
def test_a_combination_that_cannot_be_is_moved_and_told(browser, softening, name, wanted, kept, allowed):
    preset(browser, "study")
    soften(browser, softening)
    put(browser, "e", 0.85)
    put(browser, "x0", 0.05)
    if name == "b1":
        put(browser, "a1", 0.045)
    assert message(browser) == ""
    put(browser, name, wanted)
    assert message(browser).startswith(allowed)
    assert value(browser, name) == pytest.approx(kept, abs=1e-9)
    assert all(np.isfinite(list(ratios(browser).values())))
    put(browser, "e", 0.9)
    assert message(browser) == ""  # gone with the next valid change


@pytest.mark.peers
def test_the_release_follows_a_curve_that_ends_before_it(browser):
    preset(browser, "study")
    put(browser, "x0", 0.9)
    put(browser, "a3", 0.7)
    assert value(browser, "x0") == pytest.approx(0.69)
    assert "u0/u_ins is 0.9; it must be greater than 0 and less than a3" in message(browser)


@pytest.mark.peers
def test_a_preset_sets_doherty_s_curve(browser):
    for name, (b1, a1) in PRESETS.items():
        preset(browser, name)
        assert (value(browser, "b1"), value(browser, "a1"), value(browser, "a3")) == (b1, a1, 1.0)


@pytest.mark.peers
def test_a_setting_is_in_the_address_and_opens_from_there(chromium, explorer_page):
    open_page(chromium, explorer_page)
    put(chromium, "a1", 0.1)
    put(chromium, "m", 9)
    put(chromium, "e", 0.9)
    WebDriverWait(chromium, PATIENCE).until(lambda one: "e=0.9" in one.current_url)
    fragment = "#" + chromium.current_url.partition("#")[2]
    names = [control.name for control in CONTROLS]
    before = shown(chromium), [value(chromium, name) for name in names]
    open_page(chromium, explorer_page, fragment=fragment)
    assert (shown(chromium), [value(chromium, name) for name in names]) == before
    top = "return document.getElementById('explorer').getBoundingClientRect().top"
    WebDriverWait(chromium, PATIENCE).until(lambda one: abs(one.execute_script(top)) < 60)  # lands where it points
    open_page(chromium, explorer_page, fragment="#explorer?a1=0.9&b1=x&e=2&softening=none&m=3.4")
    assert complaints(chromium) == [] and "b1 is not a number in the address" in message(chromium)
    assert "e is 2; it must be" in message(chromium)
    assert np.isfinite(list(ratios(chromium).values())).all()
