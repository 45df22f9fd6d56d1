"""The phone's page in a real browser: bytes, sentences, keys, the head, faults."""

from __future__ import annotations

import base64
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from phone import Stub, broadcasting, browser, require_browser, resize, wait_for

# After each frame that is put on the canvas: its number, and the sum of all of its bytes as they
# are read back from the canvas.
_READ_BACK = """
window.readBack = [];
const table = Array.from({length: 256}, (_, n) => {
  for (let k = 0; k < 8; k++) n = n & 1 ? 0xedb88320 ^ (n >>> 1) : n >>> 1;
  return n >>> 0;
});
const put = CanvasRenderingContext2D.prototype.putImageData;
CanvasRenderingContext2D.prototype.putImageData = function (image, x, y) {
  put.call(this, image, x, y);
  const data = this.getImageData(0, 0, this.canvas.width, this.canvas.height).data;
  let sum = 0xffffffff;
  for (let i = 0; i < data.length; i++) {
    if (i % 4 !== 3) sum = table[(sum ^ data[i]) & 255] ^ (sum >>> 8);
  }
  window.readBack.push([data[0] * 65536 + data[1] * 256 + data[2], (~sum) >>> 0]);
};
"""
SIZE, RATIO = (320, 180), 2.0


@pytest.fixture(scope="module")
def driver() -> Iterator[Any]:
    require_browser()
    with browser(SIZE, RATIO, _READ_BACK) as driver:
        yield driver


@pytest.fixture(autouse=True)
def screen(driver: Any) -> Iterator[None]:
    resize(driver, SIZE)
    yield
    driver.get("about:blank")


def begin(driver: Any) -> None:
    wait_for(lambda: state(driver) == "This screen fits the rig.", "the page fits")
    driver.find_element("id", "begin").click()
    wait_for(lambda: driver.find_element("id", "picture").is_displayed(), "the picture")


def state(driver: Any) -> str:
    return str(driver.find_element("id", "state").text)


def said(driver: Any) -> list[str]:
    # In one go: the page writes its list anew while one element after the other is asked.
    script = "return [...document.querySelectorAll('#problems li')].map((each) => each.innerText)"
    return list(driver.execute_script(script))


def test_a_hundred_frames_are_the_renderers_bytes(driver: Any) -> None:
    stub = Stub()
    with broadcasting(stub) as (address, _):
        driver.get(address)
        begin(driver)
        wait_for(lambda: driver.execute_script("return readBack.length") >= 110, "110 frames", 60)
        found = driver.execute_script("return readBack")
    numbers = [number for number, _ in found]
    assert numbers == sorted(set(numbers))  # in order, none twice
    assert len(found) >= 100
    assert all(stub.sums[number] == sum_ for number, sum_ in found)
    # Both encodings were among them: the link tries each.
    assert driver.execute_script("return state.shown") >= 100


def test_the_canvas_is_pixel_for_pixel(driver: Any) -> None:
    stub = Stub(changes=False)
    with broadcasting(stub) as (address, _):
        driver.get(address)
        begin(driver)
        wait_for(lambda: driver.execute_script("return readBack.length"), "a frame")
        # Without the words before the eyes, which come and go.
        hide = "document.querySelectorAll('.prompt').forEach((each) => { each.hidden = true; })"
        driver.execute_script(hide + "; document.body.offsetTop")
        png = driver.get_screenshot_as_base64()
        # The screenshot is of the screen's pixels: those of the picture, one for one.
        shown = decoded(base64.b64decode(png))
    codes = stub._noise[7 : 7 + 360].copy()
    codes[0, 0] = (0, 0, 1)
    assert np.array_equal(shown, codes)


def decoded(png: bytes) -> np.ndarray:
    import io

    from PIL import Image

    return np.asarray(Image.open(io.BytesIO(png)).convert("RGB"))


@pytest.mark.parametrize(
    ("size", "ratio", "sentence"),
    [
        ((320, 180), 3.0, "The rig's panel has 640 x 360 pixels, this screen 960 x 540."),
        ((640, 360), 2.0, "The rig's panel has 640 x 360 pixels, this screen 1280 x 720."),
        ((180, 320), 2.0, "The phone stands upright. Turn it on its side."),
    ],
)
def test_a_screen_that_does_not_fit_is_told_why(
    driver: Any, size: tuple[int, int], ratio: float, sentence: str
) -> None:
    resize(driver, size, 0.0 if ratio == RATIO else ratio)
    with broadcasting(Stub()) as (address, _):
        driver.get(address)
        wait_for(lambda: any(sentence in each for each in said(driver)), sentence)
        assert state(driver) == "Not shown, because:"
        assert not driver.find_element("id", "picture").is_displayed()
        if ratio != RATIO or size[0] > size[1]:
            # Another screen's pixels: the server sends no frame at all.
            assert driver.execute_script("return state.shown") == 0
        # Put right, it goes on by itself.
        resize(driver, SIZE)
        wait_for(lambda: state(driver) == "This screen fits the rig.", "fitting again")


def test_a_zoomed_page_is_told_so(driver: Any) -> None:
    with broadcasting(Stub()) as (address, _):
        driver.get(address)
        begin(driver)
        found = driver.execute_script(
            "return problems({rig: {width: 640, height: 360}, screenPx: [640, 360], ratio: 2,"
            " zoom: 1.25, isLandscape: true, boxPx: [640, 360]})"
        )
        assert found == ["The page is zoomed to 125 %. Pinch until it is 100 %."]
        found = driver.execute_script(
            "return problems({rig: {width: 640, height: 360}, screenPx: [640, 360], ratio: 2.2,"
            " zoom: 1, isLandscape: true, boxPx: [704, 396]})"
        )
        assert found[0].startswith("A picture of 640 x 360 pixels would fill 704 x 396")


def test_the_test_pattern_is_read_back(driver: Any) -> None:
    with broadcasting(Stub(changes=False)) as (address, _):
        driver.get(address)
        wait_for(lambda: state(driver) == "This screen fits the rig.", "the page fits")
        driver.find_element("id", "pattern").click()
        assert driver.find_element("id", "picture").is_displayed()
        assert "pixel for pixel" in driver.find_element("id", "prompt-left").text
        shown = decoded(base64.b64decode(driver.get_screenshot_as_base64()))
        expected = 255 * (np.indices(shown.shape[:2]).sum(axis=0) % 2)
        assert np.array_equal(shown[:150, :, 1], expected[:150])


def test_keys_go_to_the_preview_table_and_prompts_come_back(driver: Any) -> None:
    from selenium.webdriver.common.action_chains import ActionChains
    from selenium.webdriver.common.keys import Keys

    stub = Stub()
    with broadcasting(stub) as (address, _):
        driver.get(address)
        begin(driver)
        ActionChains(driver).send_keys(Keys.ARROW_DOWN).send_keys("1").send_keys("]").perform()
        ActionChains(driver).key_down(Keys.CONTROL).send_keys("z").key_up(Keys.CONTROL).perform()
        wait_for(lambda: stub.pressed == ["down", "1", "]", "ctrl+z"], "keys")
        left = driver.find_element("id", "prompt-left")
        wait_for(lambda: left.text == "> left -5.00\npressed ctrl+z", "the words")
        # A tap looks straight ahead again.
        driver.find_element("id", "picture").click()
        wait_for(lambda: stub.pressed[-1] == "h", "a tap")


def test_the_headsets_one_button_steps_through_the_keys(driver: Any) -> None:
    from selenium.webdriver.common.action_chains import ActionChains

    stub = Stub()
    with broadcasting(stub) as (address, _):
        driver.get(address)
        begin(driver)
        picture = driver.find_element("id", "picture")

        def long_tap() -> str:
            ActionChains(driver).click_and_hold(picture).pause(0.8).release().perform()
            return str(driver.find_element("id", "prompt-right").text)

        assert long_tap() == "tap: left eye"
        picture.click()
        for expected in ("right eye", "both eyes", "sphere less"):
            assert long_tap() == f"tap: {expected}"
        picture.click()
        picture.click()
        wait_for(lambda: stub.pressed == ["1", "down", "down"], "the taps")
        while long_tap() != "tap: back to the page":
            pass
        picture.click()
        wait_for(lambda: driver.find_element("id", "door").is_displayed(), "the page")


def test_turning_the_phone_turns_the_head(driver: Any) -> None:
    """W3C's angles of a landscape phone: straight ahead, then 30 degrees right, 20 up."""
    stub = Stub()
    with broadcasting(stub) as (address, _):
        driver.get(address)
        begin(driver)
        turn = (
            "const e = new DeviceOrientationEvent('deviceorientation',"
            "{alpha: arguments[0], beta: arguments[1], gamma: arguments[2]});"
            "window.dispatchEvent(e)"
        )

        def is_at(yaw: float, pitch: float, angles: tuple[float, float, float]) -> bool:
            driver.execute_script(turn, *angles)
            head = stub.heads[-1]
            return abs(head.yaw_deg - yaw) < 0.2 and abs(head.pitch_deg - pitch) < 0.2

        wait_for(lambda: is_at(0.0, 0.0, (40.0, 0.0, -90.0)), "straight ahead")
        wait_for(lambda: is_at(30.0, 0.0, (10.0, 0.0, -90.0)), "to the right")
        # Looking up past the horizon flips W3C's angles: gamma 110 is -70 with alpha, beta turned.
        wait_for(lambda: is_at(30.0, -20.0, (10.0, 0.0, -70.0)), "down")
        driver.find_element("id", "picture").click()
        wait_for(lambda: is_at(0.0, -20.0, (10.0, 0.0, -70.0)), "straight ahead again")
        assert stub.has_latency is False


def test_a_fault_holds_the_picture_and_then_fades_to_grey(driver: Any) -> None:
    stub = Stub()
    grey = "return Number(getComputedStyle(document.getElementById('grey')).opacity)"
    with broadcasting(stub) as (address, _):
        driver.get(address)
        begin(driver)
        wait_for(lambda: driver.execute_script("return state.shown") > 3, "frames")
        assert driver.execute_script(grey) == 0.0
        stub.sleeps_s = 3.0  # a GPU that hangs
        wait_for(lambda: driver.execute_script(grey) == 1.0, "grey")
        stub.sleeps_s = 0.0
        wait_for(lambda: driver.execute_script(grey) == 0.0, "the picture again")
    # The server is gone: grey once more, and no error page.
    wait_for(lambda: driver.execute_script(grey) == 1.0, "grey")


def test_a_lost_socket_is_back_within_a_second(driver: Any) -> None:
    stub = Stub()
    with broadcasting(stub) as (address, _):
        driver.get(address)
        begin(driver)
        wait_for(lambda: driver.execute_script("return state.shown") > 3, "frames")
        shown = driver.execute_script("window.was = state.shown; state.socket.close(); return was")
        wait_for(lambda: driver.execute_script("return state.shown") > shown + 2, "frames again", 5)
        assert driver.find_element("id", "picture").is_displayed()


def test_a_measured_screen_is_sent(driver: Any) -> None:
    stub = Stub()
    resize(driver, (412, 915), 2.625)
    with broadcasting(stub) as (address, _):
        driver.get(address)
        wait_for(lambda: said(driver), "what does not fit")
        driver.find_element("id", "measure").click()
        driver.execute_script(
            "const it = document.getElementById('length'); it.value = 504.5;"
            "it.dispatchEvent(new Event('input'))"
        )
        # 85.60 mm are 504.5 of the page's pixels and 1324.3 of the screen's: 64.64 um.
        assert driver.find_element("id", "pitch").text == "One pixel is 64.64 um."
        driver.find_element("id", "keep").click()
        wait_for(lambda: stub.measured, "the panel")
    assert stub.measured[0].size_px == (2402, 1082)  # 915 and 412 times 2.625, rounded
    assert stub.measured[0].pixel_pitch_um == pytest.approx(64.64, abs=0.005)


def test_after_the_test_pattern_the_picture_is_back(driver: Any) -> None:
    """Of a still picture no other frame comes."""
    stub = Stub(changes=False)
    with broadcasting(stub) as (address, _):
        driver.get(address)
        begin(driver)
        wait_for(lambda: driver.execute_script("return readBack.length"), "a frame")
        driver.execute_script("at('pattern').click()")
        driver.find_element("id", "picture").click()
        wait_for(lambda: driver.execute_script("return !state.isPattern"), "the picture")
        assert driver.execute_script("return readBack.at(-1)") == [1, stub.sums[1]]


def test_a_page_that_does_not_fill_the_screen_shows_nothing(driver: Any) -> None:
    """Beside an address bar every pixel is sharp and in the wrong place."""
    with broadcasting(Stub()) as (address, _):
        driver.get(address)
        begin(driver)
        screen = {"screenWidth": SIZE[0], "screenHeight": SIZE[1], "mobile": True}
        less = {"width": SIZE[0], "height": SIZE[1] - 30, "deviceScaleFactor": 0, **screen}
        driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", less)
        sentence = "The page covers 640 x 300 of the screen's pixels, the picture needs 640 x 360."
        wait_for(lambda: any(sentence in each for each in said(driver)), sentence)
        assert not driver.find_element("id", "picture").is_displayed()
        resize(driver, SIZE)
        wait_for(lambda: driver.find_element("id", "picture").is_displayed(), "the picture")


def test_a_browser_without_fullscreen_and_unpacking_shows_it_all_the_same(driver: Any) -> None:
    """As iPhones have neither, or had."""
    with broadcasting(Stub()) as (address, _):
        driver.get(address)
        driver.execute_script(
            "Element.prototype.requestFullscreen = undefined; delete window.DecompressionStream;"
            "state.socket.close()"
        )
        wait_for(lambda: driver.execute_script("return state.isOpen && state.fits"), "the socket")
        begin(driver)
        wait_for(lambda: driver.execute_script("return state.shown") > 10, "frames")
        assert driver.execute_script("return state.isOpen")


def test_a_link_that_dies_without_a_word_gives_way_to_grey(driver: Any) -> None:
    grey = "return Number(getComputedStyle(document.getElementById('grey')).opacity)"
    with broadcasting(Stub(changes=False)) as (address, _):
        driver.get(address)
        begin(driver)
        wait_for(lambda: driver.execute_script("return state.shown"), "a frame")
        # A still picture, a server that answers: nothing is wrong.
        driver.execute_script("state.socket.onmessage = () => {}; window.was = state.socket")
        wait_for(lambda: driver.execute_script(grey) == 1.0, "grey")
        wait_for(lambda: driver.execute_script(grey) == 0.0, "another socket", 30.0)
        assert driver.execute_script("return window.was !== state.socket")


def test_a_ratio_that_is_no_whole_number_fits(driver: Any) -> None:
    """A Pixel 7: 1080 by 2400 at 2.625, told as 412 by 915 of the page's pixels."""
    with broadcasting(Stub()) as (address, _):
        driver.get(address)
        found = driver.execute_script(
            "const pixel = {rig: {width: 2400, height: 1080}, screenPx: [1082, 2402], ratio: 2.625,"
            " zoom: 1, isLandscape: true, boxPx: [2400, 1080]};"
            "return [problems({...pixel, viewPx: null}),"
            " problems({...pixel, viewPx: [2400, 1080]}),"
            " problems({...pixel, viewPx: [2402, 1082]}).length,"
            " problems({...pixel, rig: {width: 1080, height: 2400}})[0]]"
        )
        assert found[:3] == [[], [], 1]
        assert found[3].startswith("The rig's panel stands upright")
