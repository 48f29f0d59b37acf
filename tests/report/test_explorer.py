"""The explorer in a browser.

`make test-peers` drives Chromium, which comes from the system (on Debian and Ubuntu: apt-get install chromium
chromium-driver).
"""

import shutil

import numpy as np
import pytest

import rockdamp
from rockdamp.equivalence.closed_form import damping_ratio_energy, giannini_masiani
from rockdamp.errors import InputError
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.mechanics.wall import Wall
from rockdamp.report.interactive import CONTROLS
from rockdamp.vocabulary import PRESETS, VISCOUS_MODELS

try:
    from selenium import webdriver
    from selenium.common.exceptions import WebDriverException
    from selenium.webdriver.chrome.service import Service
    from selenium.webdriver.common.by import By
    from selenium.webdriver.common.keys import Keys
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
PLOTS = ("plot-decays", "plot-curve", "plot-ratios", "plot-laws")


@pytest.fixture(scope="module")
def chromium(tmp_path_factory):
    """Open a page in Chromium at a width, as a phone or not; the caller quits."""
    for found, name in ((webdriver, "selenium"), (CHROMIUM, "Chromium"), (DRIVER, "chromedriver")):
        if not found:
            pytest.skip(f"{name} is absent: `make peers` installs selenium, the system brings Chromium and its driver")

    def start(path, width=1280, phone=False, features=(), fragment=""):
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
        if features:
            named = [{"name": name, "value": value} for name, value in features]
            browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": named})
        browser.get(path.as_uri() + fragment)
        WebDriverWait(browser, 60).until(drawn)
        return browser

    return start


def drawn(browser):
    """Whether every plot has its lines."""
    return browser.execute_script(
        "return arguments[0].every((id) => document.querySelector(`#${id} path.line`) !== null)", list(PLOTS)
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
    """What a plot shows."""
    return browser.find_element(By.ID, plot).get_attribute("innerHTML")


def complaints(browser):
    return [entry for entry in browser.get_log("browser") if entry["level"] not in ("INFO", "DEBUG")]


@pytest.mark.peers
@pytest.mark.parametrize("features", [(), (("prefers-color-scheme", "dark"), ("prefers-reduced-motion", "reduce"))])
@pytest.mark.parametrize(("width", "phone"), [(1300, False), (768, False), (390, True)])
def test_the_page_opens_without_a_word_on_the_console_and_nothing_sticks_out(
    chromium, explorer_page, width, phone, features
):
    browser = chromium(explorer_page, width, phone, features)
    try:
        assert complaints(browser) == []
        wide, room = browser.execute_script(
            "const root = document.documentElement; return [root.scrollWidth, root.clientWidth]"
        )
        assert wide <= room  # what is wide scrolls by itself
        ground = browser.execute_script("return getComputedStyle(document.body).backgroundColor")
        assert (ground == "rgb(255, 255, 255)") == (not features)
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


def shown(browser):
    """What the page has computed and draws: histories, ratios and errors, u_ins and p."""
    return browser.execute_script(
        """
        const { reference, dampers, frequency, u_ins } = explorer.shown();
        const some = (history) => [...history].filter((_, i) => i % 100 === 0);
        return { u_ins, frequency, reference: some(reference), dampers: Object.fromEntries(Object.entries(dampers).map(
          ([model, { xi, error, x }]) => [model, { xi, error, x: some(x) }])) };
        """
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


@pytest.mark.peers
def test_the_page_computes_what_the_package_computes(browser):
    """50 settings, each put in as a reader does: decays, ratios, Err, and the wall's size and frequency."""
    for curve, e, x0, order, wall in random_settings(50):
        preset(browser, "study")
        soften(browser, "steeper")
        put(browser, "b1", 0.5)  # leaves room on the way for every a1 and a3
        put(browser, "a1", 0.1)
        put(browser, "a3", 1.0)
        put(browser, "a1", min(float(curve.cracked_stiffness_ratio), 0.3))
        soften(browser, curve.softening)
        for name, value in (
            ("b1", 0.09 if curve.softening == "translated" else 0.69),
            ("a3", float(curve.ultimate_ratio)),
            ("b1", float(curve.plateau_ratio)),
            ("a1", float(curve.cracked_stiffness_ratio)),
            ("e", e),
            ("x0", x0),
            ("m", order),
            ("h", 20),  # leaves room for every thickness
            ("t", float(wall.thickness)),
            ("h", float(wall.height)),
        ):
            put(browser, name, value)
        assert message(browser) == "", (curve, e, x0)
        found = shown(browser)
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
def test_the_studys_wall_resets_everything(browser):
    preset(browser, "study")
    before = shown(browser), [value(browser, control.name) for control in CONTROLS]
    put(browser, "a1", 0.1)  # b1, a3 and softening do not reach beyond what this a1 leaves
    soften(browser, "translated")
    for control in CONTROLS:
        put(browser, control.name, {"a1": 0.1, "b1": 0.6, "a3": 0.9, "m": 5}.get(control.name, 0.7))
    assert shown(browser) != before[0]
    preset(browser, "study")
    assert (shown(browser), [value(browser, control.name) for control in CONTROLS]) == before


@pytest.mark.peers
def test_a_setting_is_in_the_address_and_opens_from_there(browser, chromium, explorer_page):
    preset(browser, "study")
    put(browser, "a1", 0.1)
    put(browser, "m", 9)
    put(browser, "e", 0.9)
    WebDriverWait(browser, 5).until(lambda one: "e=0.9" in one.current_url)
    fragment = "#" + browser.current_url.partition("#")[2]
    other = chromium(explorer_page, fragment=fragment)
    try:
        assert shown(other) == shown(browser)
        names = [control.name for control in CONTROLS]
        assert [value(other, name) for name in names] == [value(browser, name) for name in names]
        top = other.execute_script("return document.getElementById('explorer').getBoundingClientRect().top")
        assert abs(top) < 60  # the link lands where it points
    finally:
        other.quit()
    other = chromium(explorer_page, fragment="#explorer?a1=0.9&b1=x&e=2&softening=none&m=3.4")
    try:
        assert complaints(other) == [] and "b1 is not a number in the address" in message(other)
        assert "e is 2; it must be" in message(other)
        assert np.isfinite(list(ratios(other).values())).all()
    finally:
        other.quit()


@pytest.mark.peers
def test_the_wall_moves_once_unless_the_reader_wants_no_motion(chromium, explorer_page):
    moving, still = (
        chromium(explorer_page, features=features) for features in ((), (("prefers-reduced-motion", "reduce"),))
    )
    try:
        time = "return Number(document.getElementById('wall-time').value)"
        WebDriverWait(moving, 10).until(lambda one: one.execute_script(time) > 0.1)
        assert still.execute_script(time) == 0
        assert not still.find_element(By.ID, "wall-play").is_displayed()
        before = picture(still, "wall-picture")
        slider = still.find_element(By.ID, "wall-time")
        slider.send_keys(Keys.ARROW_RIGHT)
        assert picture(still, "wall-picture") != before  # by the keyboard
        button = moving.find_element(By.ID, "wall-play")
        button.send_keys(Keys.ENTER)
        assert button.text == "Move"
    finally:
        moving.quit()
        still.quit()


@pytest.mark.peers
def test_every_control_answers_to_the_keyboard(browser):
    preset(browser, "study")
    for control in CONTROLS:
        before = value(browser, control.name)
        slider = browser.find_element(By.ID, f"slider-{control.name}")
        slider.send_keys(Keys.ARROW_LEFT if control.name != "m" else Keys.ARROW_RIGHT)
        assert value(browser, control.name) != before, control.name


@pytest.mark.peers
def test_chips_show_the_claims_of_one_verdict_and_links_open_what_they_point_to(browser):
    chips = browser.find_elements(By.CLASS_NAME, "chip")
    groups = browser.find_elements(By.CSS_SELECTOR, "#claims .group")
    click = "arguments[0].click()"
    browser.execute_script(click, chips[0])
    assert [group.is_displayed() for group in groups] == [True] + [False] * (len(groups) - 1)
    browser.execute_script("location.hash = '#claim-claim-1'")
    WebDriverWait(browser, 5).until(lambda _: all(group.is_displayed() for group in groups))
    top = "return document.getElementById('claim-claim-1').getBoundingClientRect().top"
    WebDriverWait(browser, 5).until(lambda one: 0 <= one.execute_script(top) < 900)  # the page scrolls smoothly
    browser.execute_script(click, chips[1])
    browser.execute_script(click, chips[1])  # again: all of them
    assert all(group.is_displayed() for group in groups)


@pytest.mark.peers
def test_the_first_cards_slider_tells_the_ratios_of_the_package(browser):
    for e in (0.6, 0.8, 0.95):
        browser.execute_script(
            "const slider = document.getElementById('answer-e'); slider.value = arguments[0];"
            "slider.dispatchEvent(new Event('input'))",
            e,
        )
        for model in VISCOUS_MODELS:
            told = float(browser.find_element(By.ID, f"answer-{model}").text)
            ratio = damping_ratio_energy(TrilinearCurve(0.04, 0.85), model, e, 0.5)
            assert told == pytest.approx(100 * float(ratio), abs=0.5001e-2)


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
