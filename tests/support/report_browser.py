"""The report in Chromium: opened as on any screen, its controls used and its pictures read as a reader does."""

try:
    from selenium.webdriver.common.by import By
    from selenium.webdriver.common.keys import Keys
    from selenium.webdriver.support.ui import WebDriverWait
except ImportError:  # the fixture of the browser skips the tests
    By = Keys = WebDriverWait = None

PATIENCE = 60  # seconds, on a machine that is busy
PLOTS = ("plot-decays", "plot-curve", "plot-ratios", "plot-laws")


def open_page(browser, path, fragment="", width=1280, phone=False, features=()):
    """Open a page anew at a width, as a phone or not, for a reader who prefers these media features."""
    metrics = {"width": width, "height": 844 if phone else 900, "deviceScaleFactor": 2 if phone else 1, "mobile": phone}
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)
    browser.execute_cdp_cmd("Emulation.setTouchEmulationEnabled", {"enabled": phone})
    named = [{"name": name, "value": value} for name, value in features]
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "", "features": named})
    browser.get("about:blank")  # another fragment alone would load nothing
    browser.get(path.as_uri() + fragment)
    WebDriverWait(browser, PATIENCE).until(drawn)


def drawn(browser):
    """Whether every plot has its lines."""
    return browser.execute_script(
        "return arguments[0].every((id) => document.querySelector(`#${id} path.line`) !== null)", list(PLOTS)
    )


def put(browser, name, value):
    """Set a number as a reader does, and let the page follow."""
    number = f"const input = document.getElementById('number-{name}'); input.value = arguments[0];"
    browser.execute_script(number + "input.dispatchEvent(new Event('change', { bubbles: true }));", str(value))


def preset(browser, name):
    button = browser.find_element(By.CSS_SELECTOR, f"[data-preset={name}]")
    browser.execute_script("arguments[0].scrollIntoView({block: 'center', behavior: 'instant'})", button)
    button.click()


def value(browser, name):
    return float(browser.find_element(By.ID, f"number-{name}").get_attribute("value"))


def message(browser):
    return browser.find_element(By.ID, "explorer-message").text


def picture(browser, plot):
    """What a plot shows."""
    return browser.find_element(By.ID, plot).get_attribute("innerHTML")


def complaints(browser):
    return [entry for entry in browser.get_log("browser") if entry["level"] not in ("INFO", "DEBUG")]


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
