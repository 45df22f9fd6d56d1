"""What the commands write is right: known results, the float64 twin, the file formats."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from command_runs import (
    BARE,
    DATA,
    LENSLETS,
    call,
    exr_file,
    light,
    png_file,
    require_done,
)
from files_by_hand import asymmetric
from numpy.typing import NDArray
from pass_rigs import KNOWN, known_results

from vrlf.images import read_codes, read_picture, srgb_decode, srgb_encode

Image = NDArray[np.float32]
# Keeps the target as it is, so that what happened to SOURCE shows in the output.
AS_TARGET = ("--set", "prefilter.method=none")


def prefiltered(folder: Path, source: Path, *options: str) -> Image:
    """What ``vrlf prefilter`` puts into an EXR."""
    file = folder / "prefiltered.exr"
    require_done(call("prefilter", source, "-o", file, *options))
    return read_picture(file)


def perceived(folder: Path, panel: Path, *options: str) -> Image:
    """What ``vrlf perceive`` puts into an EXR."""
    file = folder / "perceived.exr"
    require_done(call("perceive", panel, "-o", file, *options))
    return read_picture(file)


# Known results


@pytest.mark.parametrize("name", KNOWN)
def test_known_results_come_out_of_the_commands(tmp_path: Path, name: str) -> None:
    known = known_results(name)
    rig = ("-r", str(DATA / f"{name}.toml"))
    source = exr_file(tmp_path / "panel.exr", known["panel"])
    shown = prefiltered(tmp_path, source, *rig)
    # EXR keeps float32; the map itself is exact but for its rounding.
    assert np.abs(shown - known["forward"]).max() < 1e-5
    seen = perceived(tmp_path, source, *rig, "--exposure", "none", "--rays", "4096")
    # Two quadratures of 4096 rays differ by their noise; holes and stripes let fewer through.
    plain = not any(word in name for word in ("stripe", "holes"))
    assert np.sqrt(np.mean((seen - known["perceived"]) ** 2)) < (0.002 if plain else 0.006)


def test_the_chain_brings_the_target_nearer(tmp_path: Path) -> None:
    target = tmp_path / "target.exr"
    require_done(call("chart", "marks", *LENSLETS, "-o", target))
    shown = exr_file(tmp_path / "shown.exr", prefiltered(tmp_path, target, *LENSLETS))
    seen = perceived(tmp_path, shown, *LENSLETS)
    bare = perceived(tmp_path, target, *LENSLETS, "--set", "array.kind=none")
    wanted = read_picture(target)
    errors = [float(np.sqrt(np.mean((each - wanted) ** 2))) for each in (seen, bare)]
    assert errors[0] < 0.75 * errors[1]  # 0.58 where this was written


# Exposure


def test_auto_exposure_makes_up_for_the_light_that_holes_take(tmp_path: Path) -> None:
    holes = ("-r", str(DATA / "holes-square-perpendicular.toml"))
    panel = exr_file(tmp_path / "panel.exr", light())
    dim = perceived(tmp_path, panel, *holes, "--exposure", "none", "--rays", "16")
    bright = perceived(tmp_path, panel, *holes, "--rays", "16")
    # Square holes of 120 um every 390 um; float32 rounds the product.
    np.testing.assert_allclose(bright, dim * (390.0 / 120.0) ** 2, rtol=1e-5)


def test_more_rays_are_a_better_answer(tmp_path: Path) -> None:
    panel = exr_file(tmp_path / "panel.exr", light())
    fine = perceived(tmp_path, panel, *LENSLETS, "--rays", "8192")
    errors = [
        np.sqrt(np.mean((perceived(tmp_path, panel, *LENSLETS, "--rays", rays) - fine) ** 2))
        for rays in ("16", "128", "1024")
    ]
    assert errors[0] > 2.0 * errors[1] > 4.0 * errors[2] > 0.0


# The float64 reference


def test_the_reference_agrees_with_the_gpu(tmp_path: Path) -> None:
    panel = exr_file(tmp_path / "panel.exr", light())
    slow = ("--device", "reference")
    shown = [prefiltered(tmp_path, panel, *LENSLETS, *how) for how in ((), slow)]
    # The same map in float32 and float64.
    assert np.abs(shown[0] - shown[1]).max() < 1e-4
    seen = [perceived(tmp_path, panel, *LENSLETS, "--rays", "8", *how) for how in ((), slow)]
    # Single rays may fall on either side of a lenslet's border: 1 / 8 of a pixel's light.
    assert np.quantile(np.abs(seen[0] - seen[1]), 0.99) < 1e-4


def test_the_reference_fits_pictures_like_the_gpu(tmp_path: Path) -> None:
    given = png_file(tmp_path / "given.png", asymmetric(19, 31))
    for fit in ("contain", "cover"):
        options = (*BARE, *AS_TARGET, "--fit", fit)
        gpu = prefiltered(tmp_path, given, *options)
        reference = prefiltered(tmp_path, given, *options, "--device", "reference")
        assert np.abs(gpu - reference).max() < 1e-4, fit


# Formats


def test_eight_bits_are_within_half_a_code(tmp_path: Path) -> None:
    panel = exr_file(tmp_path / "panel.exr", light())
    exact = prefiltered(tmp_path, panel, *LENSLETS)
    file = tmp_path / "shown.png"
    require_done(call("prefilter", panel, *LENSLETS, "-o", file))
    codes = srgb_encode(read_picture(file).astype(np.float64)) * 255.0
    # A hair over a half for the GPU's float32 power.
    assert np.abs(codes - srgb_encode(exact.astype(np.float64)) * 255.0).max() < 0.502


@pytest.mark.parametrize("ending", ["png", "tif"])
def test_sixteen_bits_are_sixteen(tmp_path: Path, ending: str) -> None:
    panel = exr_file(tmp_path / "panel.exr", light())
    exact = prefiltered(tmp_path, panel, *LENSLETS)
    file = tmp_path / f"shown.{ending}"
    require_done(call("prefilter", panel, *LENSLETS, "-o", file, "--bits", "16"))
    codes = srgb_encode(read_picture(file).astype(np.float64)) * 65535.0
    assert np.abs(codes - srgb_encode(exact.astype(np.float64)) * 65535.0).max() < 0.51
    assert len(np.unique(np.round(codes))) > 256


def test_a_ten_bit_panel_is_written_in_1023_steps(tmp_path: Path) -> None:
    panel = exr_file(tmp_path / "panel.exr", light())
    exact = prefiltered(tmp_path, panel, *LENSLETS)
    deep = (*LENSLETS, "--set", "panel.bits=10")
    file, target = tmp_path / "shown.png", tmp_path / "target.png"
    require_done(call("prefilter", panel, *deep, "-o", file, "--target", target))
    steps = srgb_encode(read_picture(file).astype(np.float64)) * 1023.0
    assert np.abs(steps - np.round(steps)).max() < 0.01
    assert np.abs(steps - srgb_encode(exact.astype(np.float64)) * 1023.0).max() < 0.51
    # The target is no panel image, and one who asks for other bits gets those.
    assert read_codes(target).dtype == np.uint8
    require_done(call("prefilter", panel, *deep, "-o", file, "--bits", "8"))
    assert read_codes(file).dtype == np.uint8


def test_dither_is_the_same_noise_each_time(tmp_path: Path) -> None:
    # A ramp between two codes, which plain rounding turns into one step.
    ramp = np.linspace(100.0, 101.0, 96) / 255.0
    panel = exr_file(
        tmp_path / "ramp.exr",
        np.broadcast_to(srgb_decode(ramp)[None, :, None], (64, 96, 3)).astype(np.float32),
    )
    files = [tmp_path / name for name in ("a.png", "b.png", "plain.png")]
    for file, how in zip(files, (("--dither",), ("--dither",), ()), strict=True):
        require_done(call("prefilter", panel, *BARE, "-o", file, *how))
    assert files[0].read_bytes() == files[1].read_bytes() != files[2].read_bytes()
    codes = srgb_encode(read_picture(files[0]).astype(np.float64)) * 255.0
    # Averaged over the rows it follows the ramp: 64 x 3 samples with a spread of half a code.
    assert np.abs(codes.mean(axis=(0, 2)) - ramp * 255.0).max() < 0.15
    outcome = require_done(call("prefilter", panel, *BARE, "-o", tmp_path / "c.exr", "--dither"))
    assert "not dithered" in outcome.err


def test_encoding_says_how_numbers_are_read(tmp_path: Path) -> None:
    codes = np.full((64, 96, 3), (64, 128, 255), np.uint8)
    given = png_file(tmp_path / "given.png", codes)
    for encoding, wanted in (("linear", codes / 255.0), ("auto", srgb_decode(codes / 255.0))):
        target = prefiltered(tmp_path, given, *BARE, "--encoding", encoding)
        # Float32 rounding.
        np.testing.assert_allclose(target, wanted, atol=1e-6)
    brighter = [
        perceived(tmp_path, given, *BARE, "--rays", "4", "--encoding", encoding).mean()
        for encoding in ("linear", "srgb")
    ]
    assert brighter[0] > brighter[1]


def test_light_beyond_the_panel_is_clipped_and_said(tmp_path: Path) -> None:
    given = light()
    given[:32] = 3.0
    file = exr_file(tmp_path / "bright.exr", given)
    outcome = require_done(call("prefilter", file, *BARE, "-o", tmp_path / "a.exr"))
    assert "50 % of the values lie outside 0 to 1 and are clipped" in outcome.err
    np.testing.assert_array_equal(read_picture(tmp_path / "a.exr"), np.clip(given, 0.0, 1.0))


# What SOURCE stands for


def colours(*patches: tuple[int, int, int]) -> NDArray[np.uint8]:
    """Plain colours, a 40 x 60 patch each, side by side."""
    return np.concatenate([np.full((60, 40, 3), patch, np.uint8) for patch in patches], axis=1)


RED, GREEN = (255, 0, 0), (0, 255, 0)


def eye_colours(target: Image) -> tuple[list[int], list[int]]:
    """Colour in the middle of each eye's viewport, rounded to 0 or 1."""
    middle = np.rint(target[32, [24, 72]]).astype(int)
    return middle[0].tolist(), middle[1].tolist()


@pytest.mark.parametrize(
    ("layout", "turned"),
    [
        ("side-by-side", False),
        ("half-side-by-side", False),
        ("over-under", True),
        ("half-over-under", True),
    ],
)
def test_layouts_and_crossed_eyes(tmp_path: Path, layout: str, turned: bool) -> None:
    codes = colours(RED, GREEN)
    given = png_file(tmp_path / "given.png", np.swapaxes(codes, 0, 1) if turned else codes)
    options = (*BARE, *AS_TARGET, "--layout", layout)
    assert eye_colours(prefiltered(tmp_path, given, *options)) == ([1, 0, 0], [0, 1, 0])
    crossed = prefiltered(tmp_path, given, *options, "--cross-eyed")
    assert eye_colours(crossed) == ([0, 1, 0], [1, 0, 0])


def test_half_layouts_are_shown_at_their_full_width(tmp_path: Path) -> None:
    # Each half is 40 x 60; unsqueezed 80 x 60, which a viewport of 48 x 64 shows 36 rows of.
    given = png_file(tmp_path / "given.png", colours(RED, RED))
    squeezed = prefiltered(tmp_path, given, *BARE, *AS_TARGET, "--layout", "half-side-by-side")
    assert np.count_nonzero(squeezed[:, 24, 0] > 0.5) == 36
    plain = prefiltered(tmp_path, given, *BARE, *AS_TARGET, "--layout", "side-by-side")
    assert np.count_nonzero(plain[32, :48, 0] > 0.5) in (42, 43)  # 64 rows of 40 : 60


def test_the_files_name_tells_the_layout(tmp_path: Path) -> None:
    given = png_file(tmp_path / "film_ou.png", np.swapaxes(colours(RED, GREEN), 0, 1))
    assert eye_colours(prefiltered(tmp_path, given, *BARE)) == ([1, 0, 0], [0, 1, 0])


def test_a_file_for_each_eye(tmp_path: Path) -> None:
    left = png_file(tmp_path / "left.png", colours(RED))
    right = png_file(tmp_path / "right.png", colours(GREEN))
    target = prefiltered(tmp_path, left, *BARE, *AS_TARGET, "--right-source", str(right))
    assert eye_colours(target) == ([1, 0, 0], [0, 1, 0])


def test_fit_shows_all_or_fills_all(tmp_path: Path) -> None:
    given = png_file(tmp_path / "wide.png", np.full((20, 40, 3), 255, np.uint8))
    contained = prefiltered(tmp_path, given, *BARE, *AS_TARGET, "--fit", "contain")
    assert (contained[:, 24] > 0.5).all(axis=-1).sum() == 24  # 48 wide, so 24 rows
    covered = prefiltered(tmp_path, given, *BARE, *AS_TARGET, "--fit", "cover")
    assert covered.min() > 0.99  # white everywhere, up to the filter's rounding


def test_a_file_called_scene_goes_before_the_scene(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "scene").write_bytes(png_file(tmp_path / "a.png", colours(GREEN)).read_bytes())
    require_done(call("prefilter", "scene", *BARE, "-o", "out.exr"))
    assert eye_colours(read_picture("out.exr")) == ([0, 1, 0], [0, 1, 0])


def test_the_scene_is_drawn_for_both_eyes(tmp_path: Path) -> None:
    target = prefiltered(tmp_path, Path("scene"), *BARE, *AS_TARGET)
    assert target.shape == (64, 96, 3)
    assert target.min() >= 0.0
    assert target.max() <= 1.0
    assert target.std() > 0.05  # there is something to see
    assert not np.array_equal(target[:, :48], target[:, 48:])
    again = prefiltered(tmp_path, Path("scene"), *BARE, *AS_TARGET)
    np.testing.assert_array_equal(again, target)
