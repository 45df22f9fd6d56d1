"""Metrics of two pictures: each against its library, and answers that are known."""

from __future__ import annotations

import builtins
import sys
from math import log10, sin, sqrt
from typing import Any

import numpy as np
import pytest
from extras import needs_cvvdp
from numpy.typing import NDArray
from skimage import data, metrics

from vrlf.errors import InputError
from vrlf.evaluation.metrics import METRICS, Score, Viewing, false_colour, score
from vrlf.evaluation.metrics import table as tables
from vrlf.evaluation.metrics.colour import light_kept
from vrlf.evaluation.metrics.cvvdp import environment_kept, load_library
from vrlf.images import srgb_decode, srgb_encode

Float = NDArray[np.float64]
VIEWING = Viewing(pixels_per_degree=10.3, peak_nit=500.0)


@pytest.fixture(scope="module")
def pair() -> tuple[Float, Float]:
    """A photograph and itself with every third row dark: nothing in it is symmetric."""
    photo = srgb_decode(data.astronaut()[40:140, 150:270] / 255.0)
    worse = photo.copy()
    worse[::3] *= 0.6
    return photo, worse


def value(name: str, reference: Float, test: Float, viewing: Viewing = VIEWING) -> Any:
    scores = score([name], reference, test, viewing)
    assert not scores.failed
    return scores.values[name]


# Equal pictures.


@pytest.mark.parametrize(
    ("name", "best"),
    [
        *(("rmse", 0.0), ("ssim", 1.0), ("flip", 0.0), ("fringe", 0), ("light", 1)),
        pytest.param("cvvdp_jod", 10.0, marks=needs_cvvdp),
    ],
)
def test_equal_pictures_are_told(name: str, best: float, pair: tuple[Float, Float]) -> None:
    assert value(name, pair[0], pair[0]) == pytest.approx(best, abs=1e-12)


def test_equal_pictures_have_no_psnr_that_json_could_say(pair: tuple[Float, Float]) -> None:
    scores = score(["psnr_db"], pair[0], pair[0], VIEWING)
    assert scores.values == {"psnr_db": None}
    assert "infinite" in scores.reasons["psnr_db"]


def test_dark_pictures_are_equal_to_every_metric() -> None:
    dark = np.zeros((16, 20, 3))
    scores = score(["rmse", "ssim", "flip", "fringe"], dark, dark, VIEWING)
    assert not scores.failed
    assert scores.values == {"rmse": 0, "ssim": 1, "flip": 0, "fringe": None}


@needs_cvvdp
def test_dark_pictures_are_equal_to_cvvdp_too() -> None:
    dark = np.zeros((16, 20, 3))
    assert value("cvvdp_jod", dark, dark) == 10


# The libraries themselves.


def test_psnr_and_ssim_are_scikit_images(pair: tuple[Float, Float]) -> None:
    reference, test = pair
    assert value("psnr_db", *pair) == pytest.approx(
        metrics.peak_signal_noise_ratio(reference, test, data_range=1.0), abs=1e-9
    )
    assert value("rmse", *pair) ** 2 == pytest.approx(
        metrics.mean_squared_error(reference, test), rel=1e-12
    )
    assert value("ssim", *pair) == pytest.approx(
        metrics.structural_similarity(
            reference,
            test,
            data_range=1.0,
            channel_axis=2,
            gaussian_weights=True,
            sigma=1.5,
            use_sample_covariance=False,
        ),
        abs=1e-12,
    )


def test_flip_is_the_librarys_at_the_true_pixels_per_degree(pair: tuple[Float, Float]) -> None:
    import flip_evaluator

    encoded = [srgb_encode(each).astype(np.float32) for each in pair]
    for ppd in (10.3, 67.0):
        error_map, mean, _ = flip_evaluator.evaluate(
            *encoded, "LDR", applyMagma=False, parameters={"ppd": ppd}
        )
        scores = score(["flip"], *pair, Viewing(ppd, 500.0))
        assert scores.values["flip"] == pytest.approx(mean, abs=1e-9)
        assert scores.maps["flip"]["flip"] == pytest.approx(error_map[..., 0], abs=1e-9)
    # A mean of the map, and the published range.
    assert scores.values["flip"] == pytest.approx(float(error_map.mean()), abs=1e-6)


@needs_cvvdp
@pytest.mark.parametrize(("peak", "black"), [(500.0, 0.0), (200.0, 0.2)])
def test_cvvdp_is_the_librarys_own_srgb_display(
    peak: float, black: float, pair: tuple[Float, Float]
) -> None:
    """A display that decodes sRGB itself: (Y_peak - Y_black) linear + Y_black, its own way."""
    with environment_kept():
        library = load_library()
        metric = library.cvvdp(
            display_photometry=library.vvdp_display_photo_eotf(
                Y_peak=peak + black,
                contrast=(peak + black) / black if black else np.inf,
                source_colorspace="sRGB",
                E_ambient=0,
            ),
            display_geometry=library.vvdp_display_geometry((120, 100), ppd=10.3),
            heatmap="raw",
            quiet=True,
        )
        reference, test = (srgb_encode(each).astype(np.float32) for each in pair)
        jod, details = metric.predict(test, reference, dim_order="HWC")
    scores = score(["cvvdp_jod"], *pair, Viewing(10.3, peak, black))
    # Both in float32, one through the curve and back.
    assert scores.values["cvvdp_jod"] == pytest.approx(float(jod), abs=1e-4)
    heat = details["heatmap"].numpy().reshape(100, 120)
    assert scores.maps["cvvdp_jod"]["cvvdp"] == pytest.approx(heat, abs=2e-3)
    assert scores.values["cvvdp_jod"] < 9.0


@needs_cvvdp
def test_cvvdp_follows_the_light_and_the_angle(pair: tuple[Float, Float]) -> None:
    usual = value("cvvdp_jod", *pair)
    assert value("cvvdp_jod", *pair, Viewing(10.3, 0.5)) > usual + 0.1
    assert value("cvvdp_jod", *pair, Viewing(60.0, 500.0)) != pytest.approx(usual, abs=0.1)


# Answers known by hand.


def test_rmse_of_a_shifted_wave() -> None:
    """A wave moved by d differs by 2 A sin(pi f d) times another: RMS sqrt(2) A sin(pi f d)."""
    cycles, width, moved = 6, 120, 2
    wave = 0.5 + 0.3 * np.cos(2 * np.pi * cycles * np.arange(width) / width)
    reference = np.broadcast_to(wave[None, :, None], (20, width, 3))
    test = np.roll(reference, moved, axis=1)
    wanted = sqrt(2.0) * 0.3 * sin(np.pi * cycles * moved / width)
    assert value("rmse", reference, test) == pytest.approx(wanted, rel=1e-12)
    assert value("psnr_db", reference, test) == pytest.approx(-20 * log10(wanted), abs=1e-9)


def test_light_and_fringe_by_hand() -> None:
    grey = np.full((4, 5, 3), 0.4)
    red = grey * [1.5, 1.0, 1.0]
    assert value("light", grey, red) == pytest.approx(1.0 + 0.5 * 0.2126)
    y = 0.2126
    wanted = 0.2 * sqrt(((1 - y) ** 2 + 2 * y**2) / 3) / 0.4
    assert value("fringe", grey, red) == pytest.approx(wanted)
    assert light_kept(grey, 0.0 * grey) is None


def test_luminance_is_black_and_peak_times_linear() -> None:
    picture = np.array([[[0.0, 0.0, 0.0], [1.0, 1.0, 1.0], [0.5, 0.0, 0.0]]])
    found = Viewing(10.0, 200.0, 0.3).luminance_nit(picture)
    assert found == pytest.approx(np.array([[0.3, 200.3, 0.3 + 100 * 0.2126]]))


def test_false_colours_run_from_black_to_pale() -> None:
    colours = false_colour(np.array([[-1.0, 0.0, 0.5, 1.0, 7.0]]))
    assert colours[0].tolist()[::2] == [[0, 0, 4], [183, 55, 121], [252, 253, 191]]
    assert np.array_equal(colours[0, 1], colours[0, 0])
    assert np.array_equal(false_colour(np.array([[1.0]]), 2.0)[0, 0], colours[0, 2])


# What cannot be compared, and what is not there.


def test_pictures_that_cannot_be_compared(pair: tuple[Float, Float]) -> None:
    broken = pair[1].copy()
    broken[3, 4, 1] = np.nan
    with pytest.raises(InputError, match="test: found 1 of 36000 values NaN"):
        score(["rmse"], pair[0], broken, VIEWING)
    with pytest.raises(InputError, match="found 119x100 pixels, wanted 120x100"):
        score(["rmse"], pair[0], pair[1][:, 1:], VIEWING)
    with pytest.raises(InputError, match="wanted one of rmse, psnr_db, ssim, flip"):
        score(["rsme"], *pair, VIEWING)


@pytest.mark.parametrize("ppd", [0.0, -1.0, np.nan, np.inf])
def test_a_viewing_that_no_panel_has(ppd: float) -> None:
    with pytest.raises(InputError, match="pixels_per_degree"):
        Viewing(ppd, 500.0)
    with pytest.raises(InputError, match="black_nit"):
        Viewing(10.0, 500.0, ppd if ppd != 0.0 else -1.0)


def test_pictures_too_small_have_no_number() -> None:
    few = np.random.default_rng(1).random((3, 9, 3))
    scores = score(["ssim", "cvvdp_jod", "contrast"], few, few / 2, VIEWING)
    assert scores.values == {"ssim": None, "cvvdp_jod": None, "contrast": None}
    assert all("9x3" in scores.reasons[name] for name in ("ssim", "cvvdp_jod"))


def without(monkeypatch: pytest.MonkeyPatch, *libraries: str) -> None:
    """As where these are not installed."""
    own = builtins.__import__

    def absent(name: str, *arguments: Any, **more: Any) -> Any:
        if name.split(".")[0] in libraries:
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)
        return own(name, *arguments, **more)

    for name in [each for each in sys.modules if each.split(".")[0] in libraries]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setattr(builtins, "__import__", absent)


def test_a_missing_extra_is_named_and_the_others_go_on(
    pair: tuple[Float, Float], monkeypatch: pytest.MonkeyPatch
) -> None:
    without(monkeypatch, "flip_evaluator")
    monkeypatch.setitem(sys.modules, "pycvvdp", None)  # an import of it fails
    scores = score(["flip", "cvvdp_jod", "rmse"], *pair, VIEWING)
    assert list(scores.values) == ["rmse"]
    assert scores.failed["flip"].endswith("pip install 'vrlf[flip]'")
    assert scores.failed["cvvdp_jod"].endswith("pip install 'vrlf[cvvdp]'")


def test_a_metric_that_breaks_leaves_the_others(
    pair: tuple[Float, Float], monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(*_: Any) -> Score:
        raise RuntimeError("of its\nown")

    from dataclasses import replace

    changed = {**METRICS, "ssim": replace(METRICS["ssim"], compute=broken)}
    monkeypatch.setattr(tables, "METRICS", changed)
    scores = score(["ssim", "rmse"], *pair, VIEWING)
    assert scores.failed == {"ssim": "ssim: found RuntimeError: of its own"}
    assert "rmse" in scores.values


def test_hdr_vdp_gets_luminance_and_the_right_picture_first(pair: tuple[Float, Float]) -> None:
    from vrlf.evaluation.hdrvdp import hdr_vdp

    reference, test = pair
    y = np.array([0.2126, 0.7152, 0.0722])
    wanted = hdr_vdp(0.2 + 150.0 * (test @ y), 0.2 + 150.0 * (reference @ y), 20.0)
    scores = score(["hdr_vdp"], reference, test, Viewing(20.0, 150.0, 0.2))
    found = scores.values["hdr_vdp"]
    names = ("q_mos", "q", "p_det", "c_max")
    assert found == pytest.approx({name: getattr(wanted, name) for name in names}, rel=1e-9)
    assert scores.maps["hdr_vdp"]["P"] == pytest.approx(wanted.p_map, abs=1e-9)
    assert scores.maps["hdr_vdp"]["S"] == pytest.approx(wanted.s_map, rel=1e-9)
