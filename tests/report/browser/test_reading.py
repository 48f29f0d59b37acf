"""The page on every screen, in the reader's scheme, still where motion is not wanted, and on paper."""

import pytest
from report_browser import PATIENCE, By, Keys, WebDriverWait, complaints, open_page, picture


@pytest.mark.peers
@pytest.mark.parametrize("features", [(), (("prefers-color-scheme", "dark"), ("prefers-reduced-motion", "reduce"))])
@pytest.mark.parametrize(("width", "phone"), [(1300, False), (768, False), (390, True)])
def test_the_page_opens_without_a_word_on_the_console_and_nothing_sticks_out(
    chromium, explorer_page, width, phone, features
):
    open_page(chromium, explorer_page, width=width, phone=phone, features=features)
    assert complaints(chromium) == []
    wide, room = chromium.execute_script(
        "const root = document.documentElement; return [root.scrollWidth, root.clientWidth]"
    )
    assert wide <= room <= width  # what is wide scrolls by itself
    # Double-column figures are as wide as their text needs: they scroll by themselves where the screen is narrower.
    widest, body = chromium.execute_script(
        "const all = [...document.querySelectorAll('figure img')].map((image) => image.clientWidth);"
        " return [Math.max(...all), document.body.clientWidth]"
    )
    assert widest >= 600 and (widest <= body or phone)
    ground = chromium.execute_script("return getComputedStyle(document.body).backgroundColor")
    assert (ground == "rgb(255, 255, 255)") == (not features)


@pytest.mark.peers
def test_the_wall_moves_once_unless_the_reader_wants_no_motion(chromium, explorer_page):
    time = "return Number(document.getElementById('wall-time').value)"
    open_page(chromium, explorer_page)
    WebDriverWait(chromium, PATIENCE).until(lambda one: one.execute_script(time) > 0.1)
    button = chromium.find_element(By.ID, "wall-play")
    button.send_keys(Keys.ENTER)
    assert button.text == "Move"
    open_page(chromium, explorer_page, features=(("prefers-reduced-motion", "reduce"),))
    assert chromium.execute_script(time) == 0
    assert not chromium.find_element(By.ID, "wall-play").is_displayed()
    before = picture(chromium, "wall-picture")
    slider = chromium.find_element(By.ID, "wall-time")
    slider.send_keys(Keys.ARROW_RIGHT)
    assert picture(chromium, "wall-picture") != before  # by the keyboard


@pytest.mark.peers
def test_chips_show_the_claims_of_one_verdict_and_links_open_what_they_point_to(browser):
    chips = browser.find_elements(By.CLASS_NAME, "chip")
    groups = browser.find_elements(By.CSS_SELECTOR, "#claims .group")
    click = "arguments[0].click()"
    browser.execute_script(click, chips[0])
    assert [group.is_displayed() for group in groups] == [True] + [False] * (len(groups) - 1)
    browser.execute_script("location.hash = '#claim-claim-1'")
    WebDriverWait(browser, PATIENCE).until(lambda _: all(group.is_displayed() for group in groups))
    top = "return document.getElementById('claim-claim-1').getBoundingClientRect().top"
    WebDriverWait(browser, PATIENCE).until(lambda one: 0 <= one.execute_script(top) < 900)  # the page scrolls smoothly
    browser.execute_script(click, chips[1])
    browser.execute_script(click, chips[1])  # again: all of them
    assert all(group.is_displayed() for group in groups)


@pytest.mark.peers
def test_the_explorer_stays_off_paper(browser):
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "print"})
    try:
        assert not browser.find_element(By.ID, "explorer").is_displayed()
        assert browser.find_element(By.ID, "claims").is_displayed()
    finally:
        browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": ""})
