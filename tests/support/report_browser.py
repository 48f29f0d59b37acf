"""The report in Chromium: opened as on any screen, its controls used and its pictures read as a reader does."""

try:
    from selenium.webdriver.common.by import By
    from selenium.webdriver.common.keys import Keys
    from selenium.webdriver.support.ui import WebDriverWait
except ImportError:  # the fixture of the browser skips the tests
    By = Keys = WebDriverWait = None


def preset(browser, name):
    button = browser.find_element(By.CSS_SELECTOR, f"[data-preset={name}]")
    browser.execute_script("arguments[0].scrollIntoView({block: 'center', behavior: 'instant'})", button)
    button.click()


def message(browser):
    return browser.find_element(By.ID, "explorer-message").text


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
