"""What the explorer computes is what the package computes."""

import numpy as np
import pytest
from report_browser import PATIENCE, By, WebDriverWait, complaints, message, open_page, preset, put, shown, value

import rockdamp
from rockdamp.equivalence.closed_form import damping_ratio_energy
from rockdamp.errors import InputError
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.mechanics.damping.ecd import normalisation
from rockdamp.mechanics.wall import Wall
from rockdamp.plausibility import as_meant
from rockdamp.report import answer
from rockdamp.report.earthquake_criterion import off
from rockdamp.report.interactive import CONTROLS, LENGTH
from rockdamp.vocabulary import (
    DEFAULT_RESPONSE_LENGTH,
    RECOMMENDED,
    RECOMMENDED_ORDER,
    RECOMMENDED_SOURCE,
    VISCOUS_MODELS,
)


def random_settings(count):
    """Settings over the whole range of the sliders, with whole numbers of their steps."""
    random = np.random.default_rng(18)
    while count:
        a1, b1 = random.integers(1, 60) * 0.005, random.integers(10, 96) * 0.01
        softening = str(random.choice(["steeper", "translated"]))
        a3 = float(random.choice([1.0, round(random.uniform(0.4, 1.0), 2)]))
        try:
            curve = TrilinearCurve(a1, b1, a3, softening)
        except InputError:
            continue
        x0 = round(random.uniform(0.02, a3 - 0.02), 2)
        count -= 1
        thickness = random.uniform(0.1, 0.4)
        wall = Wall(thickness=thickness, height=thickness * random.uniform(6, 25), hinge_ratio=0.7)
        yield curve, round(random.uniform(0.5, 1.0), 3), x0, int(random.integers(0, 33)), wall


def visit(browser, setting):
    """Follow a link to a setting, and read what the page then shows and says."""
    browser.execute_async_script(
        """
        const [setting, done] = arguments;
        addEventListener("hashchange", () => done(), { once: true });
        location.hash = `explorer?${setting}`;
        """,
        setting,
    )
    return {**shown(browser), "message": message(browser)}


@as_meant()
@pytest.mark.peers
def test_the_page_computes_what_the_package_computes(browser):
    """50 settings, each opened by its address: decays, ratios, Err, and the wall's size and frequency."""
    for curve, e, x0, order, wall in random_settings(50):
        at = {"a1": curve.yield_displacement_ratio, "b1": curve.strength_ratio, "a3": curve.ultimate_displacement_ratio}
        at |= {"e": e, "x0": x0, "m": order, "t": wall.thickness, "h": wall.height}
        words = [f"{name}={float(wanted)!r}" for name, wanted in at.items()]
        found = visit(browser, "&".join([*words, f"softening={curve.softening}"]))
        assert found["message"] == "", (curve, e, x0)
        assert found["u_ins"] == pytest.approx(float(wall.instability_displacement), rel=1e-6)
        assert found["frequency"] == pytest.approx(float(wall.frequency_parameter), rel=1e-6)
        run = {"release_amplitude": x0, "step": 0.0025, "steps": 8000, "store_every": 1}
        reference = rockdamp.solve(curve, Damping.cr(e), **run).displacement
        np.testing.assert_allclose(found["reference"], reference[::100], rtol=0, atol=1e-6)
        for model in VISCOUS_MODELS:
            if model == "ECD":
                damping = Damping.of_restitution(e, order=order)
            else:
                damping = Damping(model, damping_ratio_energy(curve, model, e, x0))
            history = rockdamp.solve(curve, damping, **run).displacement
            error = np.sqrt(np.mean((np.abs(reference[1:3201]) - np.abs(history[1:3201])) ** 2))
            page = found["dampers"][model]
            assert page["xi"] == pytest.approx(float(damping.damping_ratio), abs=1e-6)
            assert page["error"] == pytest.approx(error, abs=1e-6)
            np.testing.assert_allclose(page["x"], history[::100], rtol=0, atol=1e-6)
    assert complaints(browser) == []


@pytest.mark.peers
def test_the_first_screen_follows_its_slider_with_the_ratio_and_the_errors_of_its_e(browser, content):
    advice = content.datasets["recommendation"].sel(damping_ratio_source=RECOMMENDED_SOURCE)
    least = answer.ratios(content.datasets, 0.04)
    for e, nearest in ((0.805, 0.8), (0.885, 0.9), (0.95, 0.95)):
        browser.execute_script(
            "const slider = document.getElementById('answer-e'); slider.value = arguments[0];"
            "slider.dispatchEvent(new Event('input'))",
            e,
        )
        for model in VISCOUS_MODELS:
            told = float(browser.find_element(By.ID, f"answer-{model}").text)
            assert told == pytest.approx(float(answer.shown_ratio(least, model, e)), abs=0.0101)
        card = browser.find_element(By.ID, "certain").text.replace("\u00a0", " ")
        error = off(advice["log_error"].sel(damping_model=RECOMMENDED, restitution=nearest)).replace("\u00a0", " ")
        assert f"at e = {nearest:g}" in card and f"{error} peak error (root mean square)" in card


POINTS = """
const pairs = (path) => path.match(/-?[\\d.]+ -?[\\d.]+/g).map((pair) => pair.split(" ").map(Number));
const lines = [...document.querySelectorAll(`#${arguments[0]} path.line`)];
const points = lines.map((line) => pairs(line.getAttribute("d")));
const span = document.querySelector(`#${arguments[0]} line.span`);
return [points, span && Number(span.getAttribute("x1"))];
"""  # of each line of a plot in pixels, and where its dotted line stands


@pytest.mark.peers
def test_one_unit_of_tau_is_that_of_the_wall_and_err_is_summed_up_to_the_dotted_line(browser, content):
    preset(browser, "study")
    p = float(content.config.wall.frequency_parameter)
    assert f"one unit of τ is {1 / p:.3g} s" in browser.find_element(By.ID, "explorer-size").text
    (reference, *_), span = browser.execute_script(POINTS, "plot-decays")
    start, end = reference[0][0], reference[-1][0]
    assert (span - start) / (end - start) == pytest.approx(DEFAULT_RESPONSE_LENGTH / LENGTH, abs=0.002)


@pytest.mark.peers
def test_the_moving_wall_is_where_the_decay_is_at_its_time(browser, content):
    preset(browser, "study")
    p, seconds = float(content.config.wall.frequency_parameter), 0.5
    last, corner = browser.execute_script(
        "const time = document.getElementById('wall-time'); time.value = arguments[0];"
        "time.dispatchEvent(new Event('input'));"
        "const outline = document.querySelector('.wall-reference').getAttribute('d');"
        "return [Number(time.max), Number(outline.match(/H[\\d.]+L(-?[\\d.]+)/)[1])]",
        seconds,
    )
    assert last == pytest.approx(LENGTH / p, abs=0.011)
    decay = rockdamp.free_decay(TrilinearCurve(0.04, 0.85), Damping.cr(0.85), release_amplitude=0.5)
    u = float(decay["displacement"].interp(tau=seconds * p).squeeze())
    assert corner == pytest.approx((230 + 44) / 2 + 44 * u, abs=0.5)  # the middle and the thickness in pixels


@pytest.mark.peers
def test_a_law_is_drawn_at_the_speeds_of_the_decay(browser, content):
    """ECD16 takes nothing at the release, where the wall is at rest, and at the crossing N_m times what ECD takes."""
    preset(browser, "study")
    lines, _ = browser.execute_script(POINTS, "plot-laws")
    drawn = dict(zip(VISCOUS_MODELS, lines, strict=True))
    nothing = max(y for _, y in drawn[RECOMMENDED])
    at_release = next(y for x, y in drawn[RECOMMENDED] if x >= (drawn["CDC"][0][0] + drawn["CDC"][-1][0]) / 2)
    assert at_release == pytest.approx(nothing, abs=0.11)
    constant = nothing - drawn["CDC"][0][1]
    curve = TrilinearCurve(0.04, 0.85)
    of_ecd, of_cdc = (float(damping_ratio_energy(curve, model, 0.85, 0.5)) for model in (RECOMMENDED, "CDC"))
    largest = nothing - min(y for _, y in drawn[RECOMMENDED])
    assert largest / constant == pytest.approx(normalisation(RECOMMENDED_ORDER) * of_ecd / of_cdc, rel=0.05)


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
    assert "softening is none in the address; it must be steeper or translated" in message(chromium)
    open_page(chromium, explorer_page, fragment="#explorer?e=0.9&tt=0.2")
    assert "tt in the address is none of e, " in message(chromium) and value(chromium, "e") == 0.9
