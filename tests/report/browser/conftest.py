"""One Chromium for all tests of the report in a browser.

`make test-peers` drives Chromium, which comes from the system (on Debian and Ubuntu: apt-get install chromium
chromium-driver).
"""

import shutil

import pytest

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
DRIVER = shutil.which("chromedriver")
QUIET = "headless no-sandbox disable-gpu disable-quic disable-dev-shm-usage no-first-run"
QUIET += " disable-background-networking disable-component-update disable-sync window-size=1280,900"


@pytest.fixture(scope="session")
def chromium(tmp_path_factory):
    """A browser without a page."""
    why = "`make peers` installs selenium, the system brings Chromium and its driver"
    webdriver = pytest.importorskip("selenium.webdriver", reason=f"selenium is absent: {why}")
    for found, name in ((CHROMIUM, "Chromium"), (DRIVER, "chromedriver")):
        if not found:
            pytest.skip(f"{name} is absent: {why}")
    options = webdriver.ChromeOptions()
    options.binary_location = CHROMIUM
    for argument in (*QUIET.split(), f"user-data-dir={tmp_path_factory.mktemp('profile')}"):
        options.add_argument(f"--{argument}")
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    try:
        browser = webdriver.Chrome(options=options, service=webdriver.chrome.service.Service(DRIVER))
    except webdriver.common.exceptions.WebDriverException as problem:
        pytest.skip(f"Chromium does not start here: {problem.msg}")
    yield browser
    browser.quit()


@pytest.fixture(scope="module")
def browser(chromium, explorer_page):
    """The report on a wide screen, opened anew for each file; a test that opens it otherwise opens it again."""
    from report_browser import open_page

    open_page(chromium, explorer_page)
    return chromium
