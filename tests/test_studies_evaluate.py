"""What an evaluation shows letters and edges on, how it judges, what it keeps."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command_runs import DATA, light

from vrlf.evaluation.measure import border_px, likeness
from vrlf.evaluation.metrics import METRICS
from vrlf.evaluation.metrics.edge import EdgeMtf
from vrlf.images import write_encoded
from vrlf.model import Rig, load_rig
from vrlf.optics.viewport import SIDES
from vrlf.studies.evaluate import METHODS, METRIC_NAMES, Evaluation, Question, _duration
from vrlf.studies.evaluate_charts import CHART_METRICS, chart_rig, half_frequency, read_charts
from vrlf.studies.evaluate_judge import judge, method_rig, rig_viewing
from vrlf.studies.evaluate_report import notes_of
from vrlf.studies.evaluate_store import (
    CaseFound,
    EyeFound,
    case_folder,
    key_of,
    load_case,
    slug,
    store_case,
)


@pytest.fixture(scope="module")
def small() -> Rig:
    """96 x 64 pixels, full sub-pixels, a turned microlens array."""
    return load_rig(DATA / "lenslets-turned.toml")


# Letters and an edge


def test_charts_are_shown_on_the_middle_or_on_all_of_a_small_panel(small: Rig) -> None:
    assert chart_rig(small) is small
    wide = load_rig("matched-microlens")
    cut = chart_rig(wide)
    border = max(border_px(wide, side) for side in SIDES)
    # 16 degrees at 10.29 pixels a degree and the border at each side.
    assert (cut.panel.width_px, cut.panel.height_px) == (2 * (165 + 2 * border), 165 + 2 * border)
    assert max(border_px(cut, side) for side in SIDES) == border
    assert cut.left == wide.left
    assert cut.array == wide.array


def test_both_eyes_look_at_pages_that_are_computed_once(small: Rig) -> None:
    pages: list[bytes] = []

    def show(target: Any, _: Rig) -> Any:
        pages.append(target.tobytes())
        return target

    found = read_charts(small, show, CHART_METRICS)
    assert len(pages) == len(set(pages))
    assert found["left"] == found["right"]
    # What is shown is seen: the raster's own limit is left. Letters of 5 pixels stand at 0.8 on a
    # raster of 10 pixels a degree, those of 2 pixels at 0.4.
    assert found["left"].values["acuity"]["logmar"] <= 0.6
    # The mean over a pixel: sinc(f) is half at 0.603 cycles a pixel; bins take a little.
    ppd = rig_viewing(small).pixels_per_degree
    assert found["left"].values["mtf50"] / ppd == pytest.approx(0.603, rel=0.05)
    assert found["left"].values["mtf"]["0"] == pytest.approx(1.0)


def test_a_dark_view_has_reasons_for_what_it_lacks(small: Rig) -> None:
    found = read_charts(small, lambda target, _: 0.0 * target, CHART_METRICS)["left"]
    assert found.values == {"acuity": None}
    assert "legible" in found.reasons["acuity"]
    assert found.failed.keys() == {"mtf50", "mtf"}


def test_only_what_is_asked_for_is_shown(small: Rig) -> None:
    shown: list[Any] = []

    def show(target: Any, _: Rig) -> Any:
        shown.append(target)
        return target

    found = read_charts(small, show, ["rmse", "mtf50"])
    assert len(shown) == 1
    assert found["right"].values.keys() == {"mtf50"}


def test_half_frequency_lies_between_bins() -> None:
    frequencies = np.array([0.0, 1.0, 2.0, 3.0])
    assert half_frequency(EdgeMtf(frequencies, np.array([1.0, 0.8, 0.4, 0.6]), 5.0)) == 1.75
    assert half_frequency(EdgeMtf(frequencies, np.array([1.0, 0.9, 0.8, 0.7]), 5.0)) is None


# The judge


def test_judging_is_likeness_and_maps_fill_the_viewport(small: Rig) -> None:
    target, seen = light(3), 0.5 * light(4)
    found, pictures = judge(seen, target, small, "left", ["rmse", "psnr_db", "ssim", "flip"])
    wanted = likeness(seen, target, small, "left")
    assert found.values["rmse"] == wanted.rmse
    assert found.values["gain"] == wanted.gain
    (picture,) = pictures.values()
    border = border_px(small, "left")
    assert picture.shape == (64, 48, 3)
    assert np.all(picture[:border] == 128)
    assert np.all(picture[:, -border:] == 128)
    inner = picture[border:-border, border:-border]
    assert not np.any(np.all(inner == 128, axis=2))  # no colour of a map is that grey


def test_viewing_is_the_rigs_own(small: Rig) -> None:
    viewing = rig_viewing(small)
    # The lens in the bare panel's focus: m is the distance of 46 mm.
    assert viewing.pixels_per_degree == pytest.approx(46.0 * np.pi / 180.0 / 0.078)
    assert viewing.peak_nit == small.panel.peak_nit


def test_light_knows_the_array_and_no_gain(small: Rig) -> None:
    target = light(3)
    holes = load_rig(
        DATA / "lenslets-turned.toml", overrides=["array.kind=pinhole", "array.aperture_um=195"]
    )
    for rig, share in ((holes, 0.25), (method_rig(holes, "none"), 1.0), (small, 1.0)):
        found, _ = judge(np.float32(0.8) * target, target, rig, "right", ["light"])
        # float32 on the way.
        assert found.values["light"] == pytest.approx(0.8 * share, rel=1e-6)


# What is asked


@pytest.mark.parametrize(
    ("question", "words"),
    [
        (Question([], ["rmse"]), "method: found none"),
        (Question(["magic"], ["rmse"]), "'magic'"),
        (Question(["none"], []), "metric: found none"),
        (Question(["none"], ["beauty"]), "'beauty'"),
        (Question(["none"], ["rmse"], 0), "rays"),
    ],
)
def test_a_wrong_question_is_refused(question: Question, words: str) -> None:
    from vrlf.errors import InputError

    with pytest.raises(InputError, match=words):
        question.check()


def test_every_method_and_metric_can_be_asked_for() -> None:
    Question(METHODS, METRIC_NAMES).check()
    assert set(METRIC_NAMES) == {*METRICS, *CHART_METRICS}


@pytest.mark.parametrize(
    ("seconds", "words"), [(3.4, "3 s"), (99.0, "99 s"), (600.0, "10 min"), (7200.0, "2.0 h")]
)
def test_durations(seconds: float, words: str) -> None:
    assert _duration(seconds) == words


# What is kept


def case(key: str = "k" * 64, **failed: str) -> CaseFound:
    """One of invented numbers."""
    eye = EyeFound({"rmse": 0.25, "hdr_vdp": {"q": 1.0}, "ssim": None}, {"ssim": "small"}, failed)
    return CaseFound(key, "a.png", "rig", "none", eye, eye, {})


def test_a_case_comes_back_as_it_was_kept(tmp_path: Path) -> None:
    place = case_folder(tmp_path, "x/a.png", "rig", "none", "k" * 64)
    assert place.name == "a.png--rig--none--kkkkkkkkkkkk"
    codes = np.arange(24 * 3, dtype=np.uint8).reshape(4, 6, 3)
    kept = store_case(place, case(), {"left-seen.png": codes[:, ::2]})
    assert load_case(place, "k" * 64) == kept
    assert kept.files.keys() == {"left-seen.png"}
    assert load_case(place, "j" * 64) is None
    assert load_case(tmp_path / "nowhere", "k" * 64) is None


@pytest.mark.parametrize("damage", ["picture", "gone", "record", "not a record", "other keys"])
def test_a_damaged_case_is_none(tmp_path: Path, damage: str) -> None:
    codes = np.zeros((4, 6, 3), np.uint8)
    store_case(tmp_path, case(), {"left-seen.png": codes})
    record, picture = tmp_path / "case.json", tmp_path / "left-seen.png"
    if damage == "picture":
        write_encoded(picture, codes + 1)
    elif damage == "gone":
        picture.unlink()
    elif damage == "record":
        record.write_text(record.read_text()[:-30])
    else:
        record.write_text("[1]" if damage == "not a record" else '{"left": {}, "right": {}}')
    assert load_case(tmp_path, "k" * 64) is None


def test_a_key_is_of_all_its_parts() -> None:
    assert key_of({"a": 1, "b": [2.5]}) == key_of({"b": [2.5], "a": 1})
    assert key_of({"a": 1, "b": [2.5]}) != key_of({"a": 1, "b": [2.25]})


@pytest.mark.parametrize(
    ("name", "wanted"),
    [
        ("/a/b c.png", "b-c.png"),
        ("chart:grid", "chart-grid"),
        ("..", "unnamed"),
        ("é" * 9, "unnamed"),
    ],
)
def test_slugs_are_plain_names(name: str, wanted: str) -> None:
    assert slug(name) == wanted


def test_notes_say_where_unless_everywhere() -> None:
    one, other = case(flip="flip: no library"), case(flip="flip: no library", ssim="ssim: odd")
    notes = notes_of(Evaluation((one, other), (), (), {}, 0))
    assert notes == ["flip: no library", "ssim: odd (a.png, rig, left, none, and 1 more)"]
