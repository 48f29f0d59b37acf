"""The explorer in a browser.

`make test-peers` drives Chromium, which comes from the system (on Debian and Ubuntu: apt-get install chromium
chromium-driver).
"""

import shutil

import numpy as np
import pytest

import rockdamp
from rockdamp.equivalence.closed_form import damping_ratio_energy, giannini_masiani
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.vocabulary import PRESETS, VISCOUS_MODELS

try:
    from selenium import webdriver
    from selenium.common.exceptions import WebDriverException
    from selenium.webdriver.chrome.service import Service
    from selenium.webdriver.common.by import By
    from selenium.webdriver.support.ui import Select, WebDriverWait
except ImportError:
    webdriver = None

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
DRIVER = shutil.which("chromedriver")
QUIET = (
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--disable-dev-shm-usage",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
)
PLOTS = ("plot-curve", "plot-laws", "plot-ratios", "plot-decays")


@pytest.fixture(scope="module")
def chromium(tmp_path_factory):
    """Open a page in Chromium at a width, as a phone or not; the caller quits."""
    for found, name in ((webdriver, "selenium"), (CHROMIUM, "Chromium"), (DRIVER, "chromedriver")):
        if not found:
            pytest.skip(f"{name} is absent: `make peers` installs selenium, the system brings Chromium and its driver")

    def start(path, width=1280, phone=False):
        options = webdriver.ChromeOptions()
        options.binary_location = CHROMIUM
        profile = tmp_path_factory.mktemp("profile")
        for argument in (*QUIET, f"--user-data-dir={profile}", f"--window-size={width},900"):
            options.add_argument(argument)
        if phone:
            metrics = {"width": width, "height": 844, "pixelRatio": 2.0, "mobile": True, "touch": True}
            options.add_experimental_option("mobileEmulation", {"deviceMetrics": metrics})
        options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
        try:
            browser = webdriver.Chrome(options=options, service=Service(DRIVER))
        except WebDriverException as problem:
            pytest.skip(f"Chromium does not start here: {problem.msg}")
        browser.get(path.as_uri())
        WebDriverWait(browser, 60).until(drawn)
        return browser

    return start


def drawn(browser):
    """Whether every plot has something on its canvas."""
    return browser.execute_script(
        """
        const inside = (root) => [...root.querySelectorAll("*")].flatMap((element) =>
          [element, ...(element.shadowRoot ? inside(element.shadowRoot) : [])]);
        const painted = (canvas) => canvas.width > 0 &&
          canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data.some((value) => value);
        return arguments[0].every((id) =>
          inside(document.getElementById(id)).some((one) => one.tagName === "CANVAS" && painted(one)));
        """,
        list(PLOTS),
    )


@pytest.fixture(scope="module")
def browser(chromium, explorer_page):
    browser = chromium(explorer_page)
    yield browser
    browser.quit()


def put(browser, name, value, kind="number"):
    """Set a number or a slider as a reader does, and let the page follow."""
    browser.execute_script(
        """
        const input = document.getElementById(`${arguments[2]}-${arguments[0]}`);
        input.value = arguments[1];
        input.dispatchEvent(new Event(arguments[2] === "number" ? "change" : "input", { bubbles: true }));
        """,
        name,
        str(value),
        kind,
    )


def soften(browser, softening):
    Select(browser.find_element(By.ID, "explorer-softening")).select_by_visible_text(softening)


def preset(browser, name):
    button = browser.find_element(By.CSS_SELECTOR, f"[data-preset={name}]")
    browser.execute_script("arguments[0].scrollIntoView({block: 'center', behavior: 'instant'})", button)
    button.click()


def value(browser, name):
    return float(browser.find_element(By.ID, f"number-{name}").get_attribute("value"))


def message(browser):
    return browser.find_element(By.ID, "explorer-message").text


def ratios(browser):
    return {model: float(browser.find_element(By.ID, f"xi-{model}").text) for model in VISCOUS_MODELS}


def picture(browser, plot):
    """A plot's pixels once it has settled."""
    element = browser.find_element(By.ID, plot)
    browser.execute_script("arguments[0].scrollIntoView({block: 'center', behavior: 'instant'})", element)
    seen = [element.screenshot_as_png]

    def settled(_):
        seen.append(element.screenshot_as_png)
        return seen[-1] == seen[-2]

    WebDriverWait(browser, 20, poll_frequency=0.2).until(settled)
    return seen[-1]


def complaints(browser):
    return [entry for entry in browser.get_log("browser") if entry["level"] not in ("INFO", "DEBUG")]


@pytest.mark.peers
def test_the_page_opens_without_a_word_on_the_console(chromium, explorer_page):
    for width, phone in ((1280, False), (390, True)):
        browser = chromium(explorer_page, width, phone)
        try:
            assert complaints(browser) == []
            wide, room = browser.execute_script(
                "const root = document.documentElement; return [root.scrollWidth, root.clientWidth]"
            )
            assert wide <= room  # nothing sticks out: what is wide scrolls by itself
        finally:
            browser.quit()


SETTINGS = [
    {"e": 0.85, "a1": 0.04, "b1": 0.85, "a3": 1.0, "softening": "steeper", "x0": 0.5},
    {"e": 0.7, "a1": 0.2, "b1": 0.5, "a3": 1.0, "softening": "steeper", "x0": 0.9},
    {"e": 0.92, "a1": 0.06, "b1": 0.72, "a3": 0.9, "softening": "steeper", "x0": 0.3},
    {"e": 0.8, "a1": 0.06, "b1": 0.72, "a3": 0.9, "softening": "translated", "x0": 0.61},
    {"e": 0.975, "a1": 0.105, "b1": 0.6, "a3": 0.83, "softening": "translated", "x0": 0.05},
]


@pytest.mark.peers
@pytest.mark.parametrize("given", SETTINGS)
@pytest.mark.parametrize("kind", ["number", "slider"])
def test_the_ratios_shown_are_those_of_the_command_line(browser, given, kind):
    preset(browser, "study")
    soften(browser, "steeper")
    put(browser, "b1", 0.5)  # leaves room on the way for every a1 and a3
    put(browser, "a1", 0.1)
    for name in ("e", "a1", "a3"):
        put(browser, name, given[name], kind)
    put(browser, "b1", given["b1"], kind)
    soften(browser, given["softening"])
    put(browser, "x0", given["x0"], kind)
    assert message(browser) == ""
    assert {name: value(browser, name) for name in ("e", "a1", "b1", "a3", "x0")} == pytest.approx(
        {name: given[name] for name in ("e", "a1", "b1", "a3", "x0")}, abs=1e-9
    )
    rows = rockdamp.equivalent(
        given["e"], given["a1"], given["b1"], given["a3"], given["softening"], given["x0"], window=10
    )
    assert ratios(browser) == pytest.approx(
        {row["damping_model"]: row["damping_ratio_energy"] for row in rows}, abs=1e-6
    )
    assert float(browser.find_element(By.ID, "xi-eq15").text) == pytest.approx(giannini_masiani(given["e"]), abs=1e-6)
    assert complaints(browser) == []


@pytest.mark.peers
@pytest.mark.parametrize(
    ("name", "value", "plots"),
    [
        ("a1", 0.12, ("plot-curve", "plot-laws", "plot-ratios")),
        ("b1", 0.6, ("plot-curve", "plot-laws", "plot-ratios")),
        ("a3", 0.8, ("plot-curve", "plot-laws", "plot-ratios")),
        ("e", 0.9, ("plot-laws", "plot-ratios", "plot-decays")),
        ("x0", 0.9, PLOTS),
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


def drawn_lines(browser, plot):
    """The lines of a plot as the plotting library holds them: x and y of each, in the order of drawing."""
    title = {"plot-curve": "Force", "plot-laws": "Damping c", "plot-ratios": "ξ against", "plot-decays": "Stored"}[plot]
    told = browser.execute_script(
        """
        const figures = Bokeh.documents.flatMap((document) => document.roots());
        const figure = figures.find((one) => one.title.text.startsWith(arguments[0]));
        return figure.renderers.filter((one) => one.glyph.type === "Line").map(({ data_source: { data } }) =>
          [[...data.x ?? data.get("x")], [...data.y ?? data.get("y")]]);
        """,
        title,
    )
    return [np.array(line, dtype=float) for line in told]


@pytest.mark.peers
def test_the_lines_are_those_of_the_package_and_of_the_stored_decays(browser, stored):
    preset(browser, "study")
    put(browser, "e", 0.9)
    put(browser, "x0", 0.9)
    curve = TrilinearCurve(0.04, 0.85)
    x, y = drawn_lines(browser, "plot-curve")[-1]
    np.testing.assert_allclose(y, curve.force(x), atol=1e-12)
    laws, ratios_, decays = (drawn_lines(browser, plot) for plot in PLOTS[1:])
    assert len(laws) == len(ratios_) == len(VISCOUS_MODELS)
    for model, law, ratio in zip(VISCOUS_MODELS, laws, ratios_, strict=True):
        xi = damping_ratio_energy(curve, model, 0.9, 0.9)
        np.testing.assert_allclose(law[1], Damping(model, xi).coefficient(curve, law[0]), rtol=1e-9, atol=1e-12)
        assert min(law[0].size, ratio[0].size) > 30
        np.testing.assert_allclose(ratio[1], damping_ratio_energy(curve, model, 0.9, ratio[0]), rtol=1e-9)
    assert len(decays) == stored.sizes["damping_model"]
    for decay, own in zip(
        decays, stored["displacement"].sel(restitution=0.9, release_amplitude=0.9).values, strict=True
    ):
        np.testing.assert_allclose(decay[0], stored["tau"], atol=1e-9)
        np.testing.assert_allclose(decay[1], own, atol=0.51e-4)


@pytest.mark.peers
def test_the_table_tells_the_stored_match_of_the_nearest_decay_and_the_text_which_it_is(browser, stored):
    preset(browser, "study")
    put(browser, "e", 0.88)
    put(browser, "x0", 0.33)
    near = stored.sel(restitution=0.9, release_amplitude=0.3)
    for model in VISCOUS_MODELS:
        shown = float(browser.find_element(By.ID, f"matched-{model}").text)
        assert shown == pytest.approx(float(near["damping_ratio"].sel(damping_model=model)), abs=5.1e-5)
    text = browser.find_element(By.ID, "explorer-grid").text
    assert "u0/u_ins = 0.3 and e = 0.9" in text and "not the curve set above" not in text
    put(browser, "a1", 0.1)
    assert "not the curve set above" in browser.find_element(By.ID, "explorer-grid").text


@pytest.mark.peers
@pytest.mark.parametrize(
    ("softening", "name", "wanted", "kept", "allowed"),
    [
        (
            "steeper",
            "a1",
            "0.3",
            0.145,
            "a1 is 0.3; it must be greater than 0 and less than a2, where the plateau ends",
        ),
        ("steeper", "b1", "0.97", 0.95, "b1 is 0.97; it must be greater than 1 − a3 and less than 1 − a1"),
        (
            "steeper",
            "a3",
            "0.1",
            0.16,
            "a3 is 0.1; it must be greater than 1 − b1 with steeper softening and at most 1",
        ),
        ("translated", "a3", "0.8", 0.9, "a3 is 0.8; it must be greater than a1 + b1 with translated softening"),
        ("steeper", "e", "1.2", 1.0, "e is 1.2; it must be greater than 0 and at most 1"),
        ("steeper", "x0", "1.5", 0.99, "u0/u_ins is 1.5; it must be greater than 0 and less than a3"),
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
def test_the_explorer_stays_off_paper(browser):
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "print"})
    try:
        assert not browser.find_element(By.ID, "explorer").is_displayed()
        assert browser.find_element(By.ID, "claims").is_displayed()
    finally:
        browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": ""})
