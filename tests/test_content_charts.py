"""Charts: exact sizes and places, measured on the pictures themselves."""

from __future__ import annotations

import math
import re
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from vrlf.content.charts import CHART_NAMES, Chart, draw_chart
from vrlf.content.charts.digits import DIGIT_HEIGHT, number_width_px, paint_number
from vrlf.content.charts.letters import LETTER_SHAPES, SLOAN_LETTERS, paint_letter
from vrlf.content.charts.logmar import LETTER_LINES, draw_logmar
from vrlf.content.charts.model import BLACK, BLUE, GREEN, RED, WHITE, YELLOW, Viewport
from vrlf.content.charts.raster import Box, blank, paint_rectangle, paint_shape
from vrlf.content.charts.shapes import convex_polygon, disc, rectangle
from vrlf.content.charts.usaf1951 import Element, draw_usaf1951, place_elements
from vrlf.errors import InputError

PPD = 10.3
# float32 pictures hold sums of some hundred pixels to about this.
FLOAT32_SUM = 1e-3
# 8 samples a pixel place an edge to within 1/16 pixel; a stroke has two edges.
STROKE_TOLERANCE_PX = 2 / 16


def draw(name: str, width: int = 667, height: int = 750, ppd: float = PPD, eye="left") -> Chart:
    return draw_chart(name, width_px=width, height_px=height, pixels_per_degree=ppd, eye=eye)


def letter_ink(letter: str, height_px: float, side: int) -> np.ndarray:
    """Coverage (side, side) by one letter in the upper left corner."""
    picture = blank(Viewport(side, side, 1.0, "left"), BLACK)
    paint_letter(picture, letter, left_px=0, top_px=0, height_px=height_px, colour=WHITE)
    return picture[..., 0]


# --- all charts ---------------------------------------------------------------------------


@pytest.mark.parametrize("name", CHART_NAMES)
@pytest.mark.parametrize("size", [(40, 40), (41, 57), (57, 41), (333, 375), (640, 97), (97, 640)])
def test_every_chart_draws_on_every_size(name: str, size: tuple[int, int]) -> None:
    width, height = size
    chart = draw(name, width, height)
    assert chart.image.shape == (height, width, 3)
    assert chart.image.dtype == np.float32
    assert chart.image.min() >= 0.0
    assert chart.image.max() <= 1.0
    assert np.ptp(chart.image) > 0.9, "a chart that shows nothing"
    assert chart.notes
    assert all(note == " ".join(note.split()) for note in chart.notes)


@settings(max_examples=60, deadline=None)
@given(
    name=st.sampled_from(CHART_NAMES),
    width=st.integers(40, 160),
    height=st.integers(40, 160),
    ppd=st.floats(0.1, 1e5),
)
def test_no_size_or_scale_breaks_a_chart(name: str, width: int, height: int, ppd: float) -> None:
    image = draw(name, width, height, ppd).image
    assert image.shape == (height, width, 3)
    assert np.isfinite(image).all()
    assert 0.0 <= image.min() < image.max() <= 1.0


@pytest.mark.parametrize("name", CHART_NAMES)
def test_equal_arguments_give_equal_bytes_and_a_picture_nobody_can_change(name: str) -> None:
    first, second = draw(name, 201, 158), draw(name, 201, 158)
    assert first.image.tobytes() == second.image.tobytes()
    assert first.notes == second.notes
    with pytest.raises(ValueError, match="read-only"):
        first.image[0, 0] = 0.5


@pytest.mark.parametrize("name", [name for name in CHART_NAMES if name != "marks"])
def test_all_but_marks_are_the_same_for_both_eyes(name: str) -> None:
    left, right = draw(name, 180, 160), draw(name, 180, 160, eye="right")
    np.testing.assert_array_equal(left.image, right.image)


@pytest.mark.parametrize(
    ("changed", "wanted"),
    [
        ({"name": "logmarr"}, r"found 'logmarr', wanted one of logmar, .*marks; .*'logmar'\?"),
        ({"name": "USAF"}, r"found 'USAF', .*did you mean 'usaf1951'\?"),
        ({"name": "qqq"}, r"found 'qqq', wanted one of [^;]*$"),
        ({"width_px": 39}, r"width_px: found 39, wanted a whole number from 40 to 16384"),
        ({"height_px": 16385}, r"height_px: found 16385"),
        ({"height_px": 375.0}, r"height_px: found 375\.0, wanted a whole number"),
        ({"width_px": True}, r"width_px: found True"),
        ({"pixels_per_degree": 0.0}, r"pixels_per_degree: found 0\.0, wanted a number"),
        ({"pixels_per_degree": math.nan}, r"pixels_per_degree: found nan"),
        ({"eye": "both"}, r"eye: found 'both', wanted left or right"),
    ],
)
def test_bad_input_is_one_line_that_says_what_is_wanted(changed: dict, wanted: str) -> None:
    given_ = {"name": "grid", "width_px": 90, "height_px": 80, "pixels_per_degree": PPD}
    given_ |= {"eye": "left"} | changed
    name = given_.pop("name")
    with pytest.raises(InputError, match=wanted) as caught:
        draw_chart(name, **given_)
    assert "\n" not in str(caught.value)


# --- painting -----------------------------------------------------------------------------


@given(
    left=st.floats(-5, 25),
    top=st.floats(-5, 25),
    width=st.floats(0.1, 30),
    height=st.floats(0.1, 9),
)
def test_a_rectangle_leaves_exactly_its_area(
    left: float, top: float, width: float, height: float
) -> None:
    picture = blank(Viewport(20, 17, 1.0, "left"), BLACK)
    paint_rectangle(picture, Box(left, top, width, height), WHITE)
    inside_x = max(0.0, min(left + width, 20) - max(left, 0))
    inside_y = max(0.0, min(top + height, 17) - max(top, 0))
    assert picture[..., 1].sum() == pytest.approx(inside_x * inside_y, abs=FLOAT32_SUM)


def test_a_shape_is_upright_and_cut_at_the_border() -> None:
    picture = blank(Viewport(12, 10, 1.0, "left"), BLACK)
    # The design square is 4 wide; its upper left quarter is filled.
    paint_shape(picture, rectangle(0, 2, 2, 4), Box(-2, 3, 8, 8), RED, design_side=4.0)
    wanted = np.zeros((10, 12))
    wanted[3:7, 0:2] = 1.0
    np.testing.assert_array_equal(picture[..., 0], wanted)
    assert not picture[..., 1:].any()


def test_a_disc_painted_in_bands_has_its_area() -> None:
    # 500 x 500 pixels are 16 million samples: several bands.
    picture = blank(Viewport(500, 500, 1.0, "left"), BLACK)
    paint_shape(picture, disc((1, 1), 0.9), Box(0, 0, 500, 500), WHITE, design_side=2.0)
    # Some 1400 edge pixels, each wrong by at most 1/16 and mostly at random.
    assert picture[..., 0].sum() == pytest.approx(math.pi * 225**2, abs=10)
    np.testing.assert_array_equal(picture, picture[::-1])


def test_a_polygon_holds_the_points_left_of_its_sides() -> None:
    triangle = convex_polygon((0, 0), (4, 0), (0, 2))
    x, y = np.array([1.0, 3.0, -0.1, 1.0]), np.array([1.0, 1.0, 0.5, -0.1])
    assert triangle(x, y).tolist() == [True, False, False, False]


def test_digits_are_told_apart_and_scale() -> None:
    pictures = []
    for number in range(-9, 20):
        picture = blank(Viewport(60, 40, 1.0, "left"), WHITE)
        paint_number(picture, number, left_px=4, top_px=3, scale=3, colour=BLACK)
        rows, columns = np.nonzero(picture[..., 0] == 0.0)
        assert rows.min() >= 3
        assert rows.max() < 3 + 3 * DIGIT_HEIGHT
        assert columns.max() < 4 + number_width_px(number, 3)
        pictures.append(picture.tobytes())
    assert len(set(pictures)) == len(pictures)


# --- letters ------------------------------------------------------------------------------


@pytest.mark.parametrize("letter", SLOAN_LETTERS)
@pytest.mark.parametrize("height_px", [5.0, 17.3, 40.0, 63.7])
def test_a_letter_fills_its_square_and_no_more(letter: str, height_px: float) -> None:
    ink = letter_ink(letter, height_px, 80)
    last = math.ceil(height_px)
    assert not ink[last:].any()
    assert not ink[:, last:].any()
    # Every Sloan letter touches all four sides of its square.
    reach_rows, reach_columns = ink.any(axis=1), ink.any(axis=0)
    assert reach_rows[: math.floor(height_px)].all()
    assert reach_columns[: math.floor(height_px)].all()


@pytest.mark.parametrize("height_px", [15.0, 17.3, 43.0, 60.0])
def test_straight_strokes_are_a_fifth_of_the_letter(height_px: float) -> None:
    stroke = height_px / 5
    middle = int(height_px / 2)
    quarter = int(height_px * 0.3)
    h, z, n, d = (letter_ink(letter, height_px, 70) for letter in "HZND")
    # H a third of the way down: two stems. Its middle column: the bar alone.
    assert h[quarter].sum() == pytest.approx(2 * stroke, abs=2 * STROKE_TOLERANCE_PX)
    assert h[:, middle].sum() == pytest.approx(stroke, abs=STROKE_TOLERANCE_PX)
    # A stem is as high as the letter; the first column lies in it whole.
    assert h[:, 0].sum() == pytest.approx(height_px, abs=STROKE_TOLERANCE_PX)
    assert d[:, 0].sum() == pytest.approx(height_px, abs=STROKE_TOLERANCE_PX)
    # Z's diagonal stands 3-4-5: a unit across is 5/4 along the row.
    assert z[middle].sum() == pytest.approx(1.25 * stroke, abs=STROKE_TOLERANCE_PX)
    # N in the middle row: two stems and the same diagonal.
    assert n[middle].sum() == pytest.approx(3.25 * stroke, abs=3 * STROKE_TOLERANCE_PX)


@pytest.mark.parametrize(
    ("letter", "row_share", "strokes_along_row"),
    [
        # K: stem and two limbs at 45 degrees, sqrt(2) units along a row each.
        ("K", 0.1, 1 + math.sqrt(2)),
        ("K", 0.9, 1 + math.sqrt(2)),
        # V: two limbs of one unit across, (sqrt(3100) - 2.5) / 49.5 along a row.
        ("V", 0.1, 2 * (math.sqrt(3100) - 2.5) / 49.5),
        # R: stem and a 3-4-5 leg.
        ("R", 0.9, 1 + 1.25),
    ],
)
def test_slanted_strokes_are_a_fifth_across(
    letter: str, row_share: float, strokes_along_row: float
) -> None:
    height_px = 100.0
    ink = letter_ink(letter, height_px, 110)
    row = ink[int(row_share * height_px)]
    assert row.sum() == pytest.approx(strokes_along_row * 20.0, abs=2 * STROKE_TOLERANCE_PX)


@pytest.mark.parametrize("height_px", [20.0, 50.0])
def test_round_strokes_have_the_area_of_true_arcs(height_px: float) -> None:
    unit = height_px / 5
    ring = math.pi * (2.5**2 - 1.5**2) * unit**2
    # The gap: one unit high, between the circles.
    circle = lambda r: 0.5 * math.sqrt(r**2 - 0.25) + r**2 * math.asin(0.5 / r)  # noqa: E731
    gap = (circle(2.5) - circle(1.5)) * unit**2
    half_bowl = math.pi * (1.5**2 - 0.5**2) / 2 * unit**2
    areas = {
        "O": ring,
        "C": ring - gap,
        "D": ring / 2 + (5 + 2 * 1.5) * unit**2,
        "S": 3 * half_bowl + 3 * 2 * unit**2,
    }
    for letter, area in areas.items():
        ink = letter_ink(letter, height_px, 60)
        # Supersampling errs at random along the edge: well below one per cent.
        assert ink.sum() == pytest.approx(area, rel=0.01), letter


def test_o_is_round_and_c_opens_to_the_right() -> None:
    # An odd height puts the axis of symmetry through pixel centres, an even one between.
    for height in (25, 40):
        o, c = (letter_ink(letter, height, height) for letter in "OC")
        np.testing.assert_array_equal(o, o[:, ::-1])
        np.testing.assert_array_equal(o, o[::-1])
        np.testing.assert_array_equal(o, o.T)
        np.testing.assert_array_equal(c, c[::-1])
        np.testing.assert_array_equal(c[:, : height // 2], o[:, : height // 2])
        gap_rows = c[:, -2] == 0.0
        assert not c[height // 2, height // 2 :].any()
        assert c[height // 2, 0] == pytest.approx(1.0, abs=0.1)
        assert gap_rows[height // 2 - height // 10 + 1 : height // 2 + height // 10].all()
        # The gap is a stroke high: what O has there and C has not.
        missing = (o - c)[:, int(0.9 * height)]
        assert missing.sum() == pytest.approx(height / 5, abs=STROKE_TOLERANCE_PX)


def test_letters_that_a_turn_maps_onto_themselves() -> None:
    for letter in "HNOSZ":
        ink = letter_ink(letter, 50.0, 50)
        # Samples that fall exactly on a closed slanted edge count on one side only.
        assert np.abs(ink - ink[::-1, ::-1]).max() <= 1 / 8, letter
    for letter in "CDKRV":
        ink = letter_ink(letter, 50.0, 50)
        assert np.abs(ink - ink[::-1, ::-1]).max() > 0.9, letter


def test_no_two_shapes_are_alike() -> None:
    pictures = {letter: letter_ink(letter, 50.0, 50) for letter in LETTER_SHAPES}
    names = list(pictures)
    for i, one in enumerate(names):
        for other in names[i + 1 :]:
            # A unit square is 100 pixels; even C and O differ by as much.
            assert np.abs(pictures[one] - pictures[other]).sum() > 90, (one, other)


# --- logmar -------------------------------------------------------------------------------


def test_the_letters_of_the_lines() -> None:
    assert len(set(LETTER_LINES)) == len(LETTER_LINES)
    assert all(len(set(line)) == 5 and set(line) <= set(SLOAN_LETTERS) for line in LETTER_LINES)
    for letters in (3, 4, 5):
        read = "".join(line[:letters] for line in LETTER_LINES)
        assert not re.search(r"(.)\1", read)
        assert len({line[:letters] for line in LETTER_LINES}) == len(LETTER_LINES)
    for upper, lower in pairwise(LETTER_LINES):
        assert all(a != b for a, b in zip(upper, lower, strict=True))
    for first, second in zip(LETTER_LINES[::2], LETTER_LINES[1::2], strict=True):
        assert set(first + second) == set(SLOAN_LETTERS)


@pytest.mark.parametrize(("width", "height", "ppd"), [(667, 750, PPD), (333, 375, 22.7)])
def test_logmar_lines_fall_in_steps_to_the_smallest_that_pixels_carry(
    width: int, height: int, ppd: float
) -> None:
    lines = draw("logmar", width, height, ppd).lines
    for line in lines:
        # 5 minutes of arc at logMAR 0.
        assert line.letter_height_px == pytest.approx(5 / 60 * ppd * 10**line.logmar, rel=1e-12)
        assert line.decimal_acuity == pytest.approx(10**-line.logmar, rel=1e-12)
        assert len(line.letters) == 5
    for upper, lower in pairwise(lines):
        assert upper.logmar - lower.logmar == pytest.approx(0.1, abs=1e-12)
        # The gap is the lower line's height; both tops are rounded by half a pixel.
        gap = lower.y_px - upper.y_px - upper.letter_height_px
        assert gap == pytest.approx(lower.letter_height_px, abs=1.0 + 1e-9)
    step = 10**0.1
    assert 5.0 <= lines[-1].letter_height_px < 5.0 * step
    # Five letters, four gaps, a quarter of white each side; the next step is too wide.
    assert lines[0].letter_height_px * 9.5 <= width < lines[0].letter_height_px * step * 9.5


def test_exactly_one_pixel_a_stroke_still_is_a_line() -> None:
    assert draw("logmar", 300, 300, 60.0).lines[-1].letter_height_px == 5.0
    assert draw("logmar", 300, 300, 60.0).lines[-1].logmar == 0.0
    assert draw("logmar", 300, 300, 59.9).lines[-1].logmar == 0.1
    assert draw("logmar", 300, 300, 90.0).lines[-1].logmar == -0.1


def test_logmar_ink_lies_where_the_lines_say() -> None:
    chart = draw("logmar")
    ink = 1.0 - chart.image[..., 0]
    np.testing.assert_array_equal(chart.image[..., 0], chart.image[..., 2])
    left_over = ink.copy()
    for line in chart.lines:
        height = line.letter_height_px
        band = ink[line.y_px : line.y_px + math.ceil(height)]
        left_over[line.y_px : line.y_px + math.ceil(height)] = 0.0
        columns = np.flatnonzero(band.any(axis=0))
        starts = columns[np.flatnonzero(np.diff(columns, prepend=-2) > 1)]
        # K, R and S have no white column, so runs of ink are the letters.
        assert len(starts) == 5
        # A letter and its gap are two heights; both places are rounded.
        assert np.diff(starts) == pytest.approx(2 * height, abs=1.0 + 1e-9)
        for start, letter in zip(starts, line.letters, strict=True):
            side = math.ceil(height)
            drawn = band[:, start : start + side]
            # 1 - (1 - ink) in float32.
            np.testing.assert_allclose(drawn, letter_ink(letter, height, side), atol=1e-6)
        # Centred to within the rounding of the places.
        assert starts[0] + 4.5 * height == pytest.approx(667 / 2, abs=0.5 + 1e-9)
    assert not left_over.any()


def test_a_low_viewport_keeps_the_small_lines() -> None:
    low, high = draw("logmar", 667, 120).lines, draw("logmar", 667, 750).lines
    assert low[-1].logmar == high[-1].logmar
    assert low[0].logmar < high[0].logmar
    assert low[-1].y_px + low[-1].letter_height_px <= 120


def test_a_narrow_viewport_gets_fewer_letters() -> None:
    assert {len(line.letters) for line in draw("logmar", 40, 90).lines} == {3}


@pytest.mark.parametrize("draw_one", [draw_logmar, draw_usaf1951])
def test_a_viewport_without_room_for_one_line_is_refused(draw_one) -> None:
    with pytest.raises(InputError, match=r"found a viewport of 21 x 19 px, wanted room for"):
        draw_one(Viewport(21, 19, PPD, "left"))


def test_logmar_notes_state_each_line() -> None:
    chart = draw("logmar", 667, 750, 11.7)
    for number, (line, note) in enumerate(zip(chart.lines, chart.notes[1:], strict=True), start=1):
        assert note.startswith(
            f"line {number}: logMAR {line.logmar:.2f}, decimal acuity {line.decimal_acuity:.3g}, "
            f"letter {line.letter_height_px:.1f} px high"
        )


# --- usaf1951 -----------------------------------------------------------------------------


def triplet_ink(image: np.ndarray, element: Element) -> tuple[np.ndarray, np.ndarray]:
    side = math.ceil(element.triplet_px)
    rows = slice(element.top_px, element.top_px + side)
    return tuple(
        1.0 - image[rows, left : left + side, 0]
        for left in (element.upright_left_px, element.level_left_px)
    )


@pytest.mark.parametrize(("width", "height"), [(667, 750), (333, 375), (40, 40)])
def test_usaf_bars_have_their_width_on_the_picture(width: int, height: int) -> None:
    image = draw("usaf1951", width, height).image
    elements = place_elements(Viewport(width, height, PPD, "left"))
    for e in elements:
        # A cycle is a bar and a gap.
        assert e.bar_px == pytest.approx(PPD / 2 / e.cycles_per_degree, rel=1e-12)
        wanted = 2.0 ** (e.group + (e.element - 1) / 6)
        assert e.cycles_per_degree == pytest.approx(wanted, rel=1e-12)
        upright, level = triplet_ink(image, e)
        # Row 0 lies wholly in the upright bars, column 0 in the level ones.
        assert upright[0].sum() == pytest.approx(3 * e.bar_px, abs=FLOAT32_SUM)
        assert level[:, 0].sum() == pytest.approx(3 * e.bar_px, abs=FLOAT32_SUM)
        assert upright[:, 0].sum() == pytest.approx(5 * e.bar_px, abs=FLOAT32_SUM)
        np.testing.assert_allclose(level, upright.T, atol=1e-6)  # float32
    for coarse, fine in pairwise(elements):
        assert coarse.bar_px / fine.bar_px == pytest.approx(2 ** (1 / 6), rel=1e-12)
    assert 1.0 <= elements[-1].bar_px < 2 ** (1 / 6)


@settings(max_examples=20, deadline=None)
@given(width=st.integers(40, 300), height=st.integers(40, 300), ppd=st.floats(1.0, 200.0))
def test_usaf_targets_lie_inside_and_apart(width: int, height: int, ppd: float) -> None:
    taken = np.zeros((height, width), dtype=int)
    for e in place_elements(Viewport(width, height, ppd, "left")):
        assert min(e.left_px, e.top_px) >= 0
        assert e.right_px <= width
        assert e.bottom_px <= height
        taken[e.top_px : e.bottom_px, e.left_px : e.right_px] += 1
    assert taken.max() == 1


def test_usaf_large_viewport_shows_whole_groups_and_says_so() -> None:
    notes = draw("usaf1951").notes
    assert notes[0].startswith("group 0 element 1 is 1 cycle per degree: bars 5.15 px wide")
    assert "group 1 element 4: 2.828 cycles per degree, bars 1.82 px wide" in notes
    assert notes[-1] == "group 2 element 3: 5.040 cycles per degree, bars 1.02 px wide"


# --- siemens ------------------------------------------------------------------------------


@pytest.mark.parametrize("size", [(333, 375), (300, 222), (40, 40)])
def test_a_ring_of_the_star_has_36_cycles(size: tuple[int, int]) -> None:
    width, height = size
    image = draw("siemens", width, height).image[..., 0]
    outer = min(width, height) / 2 - 1
    angle = (np.arange(4096) + 0.5) / 4096 * 2 * np.pi
    for radius in np.linspace(max(14.0, outer * 0.3), outer - 3, 4):
        columns = np.floor(width / 2 + radius * np.cos(angle)).astype(int)
        rows = np.floor(height / 2 - radius * np.sin(angle)).astype(int)
        spectrum = np.abs(np.fft.rfft(image[rows, columns] - 0.5))
        assert spectrum.argmax() == 36, radius


def test_the_star_is_antialiased_like_a_finely_sampled_one() -> None:
    side, fine = 120, 16
    image = draw("siemens", side, side).image[..., 0]
    place = (np.arange(side * fine) + 0.5) / fine - side / 2
    white = np.sin(36 * np.arctan2(-place[:, None], place[None, :])) > 0
    sampled = white.reshape(side, fine, side, fine).mean(axis=(1, 3))
    pixel = np.arange(side) + 0.5 - side / 2
    radius = np.hypot(pixel[:, None], pixel[None, :])
    ring = (radius > 14) & (radius < side / 2 - 3)
    # A pixel on a slant is up to sqrt(2) wide where the formula takes 1: a corner
    # of it holds at most 1/8 of the area beyond an edge at half a pixel.
    error = np.abs(image - sampled)[ring]
    assert error.max() < 0.15
    assert error.mean() < 0.02


def test_the_star_ends_in_grey_inside_and_outside() -> None:
    chart = draw("siemens", 201, 181)
    assert chart.image[90, 100] == pytest.approx([0.5] * 3)
    assert chart.image[0, 0] == pytest.approx([0.5] * 3)
    radius = float(re.search(r"Nyquist at radius ([\d.]+) px", chart.notes[1])[1])
    # A cycle is two pixels there: 36 cycles on a circumference of 72 pixels.
    assert 2 * math.pi * radius == pytest.approx(72, abs=0.05)  # two decimals in the note
    assert "5.15 cycles per degree" in chart.notes[1]
    # 36 cycles on the outer circumference, in pixels, times pixels per degree.
    assert f"{36 / (2 * math.pi * 89.5) * PPD:.2f} cycles per degree at the outer" in chart.notes[2]


# --- grid ---------------------------------------------------------------------------------


@pytest.mark.parametrize(("width", "height"), [(333, 375), (260, 181)])
def test_grid_lines_stand_a_degree_apart(width: int, height: int) -> None:
    image = draw("grid", width, height).image
    # The blue of the picture has neither the red cross nor the yellow circle added;
    # a row and a column far from both and between lines.
    column, row = width // 2, height // 2
    across = image[row + 4 - 10 * (row // 10), :, 2]
    down = image[:, column + 4 - 10 * (column // 10), 2]
    for profile, centre in ((across, column), (down, row)):
        wanted = np.zeros_like(profile)
        for place in range(len(profile)):
            number, rest = divmod(place - centre + 1, 10)
            if rest == 1 or (rest < 3 and number % 5 == 0):
                wanted[place] = 1.0
        np.testing.assert_array_equal(profile, wanted)


def test_grid_circle_is_round_and_the_cross_stands_in_its_middle() -> None:
    chart = draw("grid", 333, 375)
    image = chart.image
    assert "column 166, row 187" in chart.notes[1]
    assert (image[187, 166 - 10 : 166 + 11] == RED).all()
    assert (image[187 - 10 : 187 + 11, 166] == RED).all()
    # The circle is the only yellow: full red and green without blue.
    rows, columns = np.nonzero((image[..., 1] > 0.5) & (image[..., 2] < 0.5))
    radius = np.hypot(rows - 187, columns - 166)
    # 2 pixels wide, blurred by one: pixels above half lie within one of the radius.
    assert np.abs(radius - 150).max() <= 1.0
    assert rows.min() + rows.max() == 2 * 187
    assert columns.min() + columns.max() == 2 * 166


def test_grid_keeps_lines_apart_where_degrees_are_small_and_in_sight_where_large() -> None:
    assert draw("grid", 100, 100, 0.7).notes[0].startswith("lines each 4 px (5.71 degrees)")
    assert draw("grid", 100, 88, 500.0).notes[0].startswith("lines each 22 px (0.044 degrees)")


# --- points -------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("width", "height", "ppd"), [(667, 750, PPD), (333, 375, 5.5), (40, 41, PPD), (90, 60, 0.2)]
)
def test_points_are_exactly_the_pixels_stated(width: int, height: int, ppd: float) -> None:
    chart = draw("points", width, height, ppd)
    across, down, spacing = map(
        int, re.match(r"(\d+) x (\d+) single pixels, (\d+) px", chart.notes[0]).groups()
    )
    column, row = map(int, re.search(r"column (\d+), row (\d+)", chart.notes[1]).groups())
    wanted = np.zeros((height, width, 3), np.float32)
    for j in range(down):
        for i in range(across):
            colour = (WHITE, RED, GREEN, BLUE)[(i + 2 * j) % 4]
            wanted[row + j * spacing, column + i * spacing] = colour
    np.testing.assert_array_equal(chart.image, wanted)
    assert spacing % 2 == 1
    assert across >= 2
    assert down >= 2
    # Centred: what is left over at the two ends differs by one pixel at most.
    assert abs(column - (width - 1 - column - (across - 1) * spacing)) <= 1
    assert {tuple(c) for c in wanted.reshape(-1, 3).tolist()} == {BLACK, WHITE, RED, GREEN, BLUE}


def test_points_stand_two_degrees_apart() -> None:
    assert "21 px (2.04 degrees) apart" in draw("points").notes[0]


# --- marks --------------------------------------------------------------------------------


@pytest.mark.parametrize("size", [(333, 375), (375, 200), (40, 40), (41, 91)])
@pytest.mark.parametrize("eye", ["left", "right"])
def test_marks_have_a_colour_for_each_corner(size: tuple[int, int], eye: str) -> None:
    width, height = size
    chart = draw("marks", width, height, eye=eye)
    side = int(re.search(r"corner squares of (\d+) px", chart.notes[1])[1])
    image = chart.image
    assert (image[:side, :side] == RED).all()
    assert (image[:side, -side:] == GREEN).all()
    assert (image[-side:, :side] == BLUE).all()
    assert (image[-side:, -side:] == YELLOW).all()
    # No sign reaches into a square, or a square into a sign.
    assert (image[side, :side] == BLACK).all()
    assert (image[:side, side] == BLACK).all()
    assert f"the {eye} eye: the letter {eye[0].upper()}" in chart.notes[0]


def test_marks_show_the_eyes_letter_and_up() -> None:
    left, right = (draw("marks", 200, 200, eye=eye).image[..., 0] for eye in ("left", "right"))
    # 0.40, 0.125 and 0.20 of 200 px.
    for image, letter in ((left, "L"), (right, "R")):
        ink = letter_ink(letter, 80, 80)
        assert (np.abs(image[102:182, 60:140] - ink) < 1e-6).all(), letter
    arrow = letter_ink("↑", 40, 40)
    np.testing.assert_allclose(left[18:58, 80:120], arrow, atol=1e-6)  # float32
    # The arrow's head is above: its tip lies in the upper half.
    assert (arrow[:20] > 0).sum(axis=1).max() > (arrow[20:] > 0).sum(axis=1).max()
    np.testing.assert_allclose(left[68:93, 69:94], letter_ink("U", 25, 25), atol=1e-6)
    np.testing.assert_allclose(left[68:93, 106:131], letter_ink("P", 25, 25), atol=1e-6)


@pytest.mark.parametrize("eye", ["left", "right"])
def test_every_mirror_and_turn_of_the_marks_shows(eye: str) -> None:
    image = draw("marks", 120, 120, eye=eye).image
    seen = []
    for turns in range(4):
        turned = np.rot90(image, turns)
        seen += [turned.tobytes(), np.ascontiguousarray(turned[:, ::-1]).tobytes()]
    assert len(set(seen)) == 8
