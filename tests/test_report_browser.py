"""The report in a browser without a screen: no request, no broken picture; slider and table."""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterator
from typing import Any

import pytest
from report_by_hand import report

from vrlf.evaluation.report import report_html

BROWSER, DRIVER = shutil.which("chromium"), shutil.which("chromedriver")


@pytest.fixture(scope="module")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    """Chromium, showing the invented report from the disk."""
    webdriver = pytest.importorskip("selenium.webdriver", reason="selenium is not installed")
    if BROWSER is None or DRIVER is None:
        pytest.skip("chromium and chromedriver are not installed")
    options = webdriver.ChromeOptions()
    options.binary_location = BROWSER
    profile = tmp_path_factory.mktemp("profile")
    for word in ("--headless=new", "--no-sandbox", "--disable-gpu", f"--user-data-dir={profile}"):
        options.add_argument(word)
    options.set_capability("goog:loggingPrefs", {"performance": "ALL", "browser": "ALL"})
    driver = webdriver.Chrome(options=options, service=webdriver.ChromeService(DRIVER))
    try:
        file = tmp_path_factory.mktemp("report") / "report.html"
        file.write_text(report_html(report()), encoding="utf-8")
        driver.set_window_size(1200, 900)
        driver.get(file.as_uri())
        yield driver
    finally:
        driver.quit()


def test_it_asks_for_nothing_but_itself(browser: Any) -> None:
    messages = [json.loads(entry["message"])["message"] for entry in browser.get_log("performance")]
    asked = [
        message["params"]["request"]["url"]
        for message in messages
        if message["method"] == "Network.requestWillBeSent"
        # The browser's own first page has requests of its own.
        and message["params"]["documentURL"] == browser.current_url
    ]
    assert browser.current_url in asked  # the log is alive
    assert [url for url in asked if not url.startswith("data:")] == [browser.current_url]
    # Neither a script's error nor a breach of the content security policy.
    assert browser.get_log("browser") == []


def test_no_picture_is_broken(browser: Any) -> None:
    widths = browser.execute_script("return [...document.images].map(i => i.naturalWidth)")
    assert len(widths) == 4 * 9 + 1 + 4 * 2  # two more in each comparison
    assert min(widths) > 0


@pytest.fixture
def compare(browser: Any) -> Any:
    """The first comparison."""
    return browser.find_element("css selector", ".compare")


def test_the_slider_cuts_the_upper_picture(browser: Any, compare: Any) -> None:
    clip = "return getComputedStyle(arguments[0].querySelector('.over')).clipPath"
    assert "50%" in browser.execute_script(clip, compare)
    slider = compare.find_element("css selector", "input[type=range]")
    browser.execute_script(
        "arguments[0].value = 20; arguments[0].dispatchEvent(new Event('input'))", slider
    )
    assert "20%" in browser.execute_script(clip, compare)
    from selenium.webdriver.common.keys import Keys

    slider.send_keys(Keys.ARROW_RIGHT)
    assert "20.5%" in browser.execute_script(clip, compare)
    assert slider.get_attribute("aria-valuetext") == "21 percent from the left"


def test_the_pointer_moves_the_slider(browser: Any, compare: Any) -> None:
    from selenium.webdriver import ActionChains

    stage = compare.find_element("css selector", ".stage")
    browser.execute_script("arguments[0].scrollIntoView({block: 'center'})", stage)
    away = round(stage.size["width"] / 4)
    ActionChains(browser).move_to_element_with_offset(stage, away, 0).click().perform()
    value = float(compare.find_element("css selector", "input[type=range]").get_property("value"))
    assert value == pytest.approx(75.0, abs=1.0)  # a step of half a percent, a pixel's rounding


def test_a_choice_changes_the_picture(browser: Any, compare: Any) -> None:
    from selenium.webdriver.support.ui import Select

    under = compare.find_element("css selector", ".under")
    before = under.get_property("src")
    choice = Select(compare.find_element("css selector", "select.first"))
    assert choice.first_selected_option.text == "seen, uncorrected"
    choice.select_by_visible_text("target")
    source = browser.find_element("id", "pair0-left-target").get_property("src")
    assert before != under.get_property("src") == source
    assert under.get_property("alt") == "Left eye: the target"
    Select(compare.find_element("css selector", "select.zoom")).select_by_value("4")
    assert compare.find_element("css selector", ".stage").size["width"] == 4 * 32


def column(browser: Any, place: int) -> list[str]:
    """Texts of a column, as they stand."""
    cells = browser.find_elements("css selector", f"tbody tr td:nth-child({place})")
    return [cell.text for cell in cells]


def test_the_table_sorts_by_a_click(browser: Any) -> None:
    heads = browser.find_elements("css selector", "table.sortable th")
    place = [head.text for head in heads].index("PSNR, dB")
    browser.execute_script("arguments[0].scrollIntoView({block: 'center'})", heads[place])
    before = column(browser, place + 1)
    heads[place].click()
    rising = column(browser, place + 1)
    # 9.25 stands before 12.5, which as text it would not; what is not defined stands last.
    assert rising != before
    numbers = [float(text) for text in rising[:-1]]
    assert numbers == sorted(numbers)
    assert rising[-1] == "–"
    assert heads[place].get_attribute("aria-sort") == "ascending"
    heads[place].find_element("css selector", "button").click()
    falling = column(browser, place + 1)
    assert falling == [*reversed(rising[:-1]), "–"]
    heads[3].click()
    assert column(browser, 4) == [
        method for method in ("forward", "none", "optimal") for _ in "1234"
    ]
    assert heads[place].get_attribute("aria-sort") == "none"


def test_squares_can_be_turned_off(browser: Any) -> None:
    rendering = (
        "return getComputedStyle(document.getElementById('pair0-left-target')).imageRendering"
    )
    assert browser.execute_script(rendering) == "pixelated"
    box = browser.find_element("id", "squares")
    browser.execute_script("arguments[0].click()", box)
    assert browser.execute_script(rendering) == "auto"


def test_a_phone_needs_no_scrolling_sideways(browser: Any) -> None:
    browser.execute_cdp_cmd(
        "Emulation.setDeviceMetricsOverride",
        {"width": 360, "height": 740, "deviceScaleFactor": 2, "mobile": True},
    )
    try:
        assert browser.execute_script("return document.documentElement.scrollWidth") == 360
    finally:
        browser.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})
