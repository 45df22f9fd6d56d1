"""Reading: upright, exact, and one line for whatever cannot be read."""

from __future__ import annotations

import os
import struct
from collections.abc import Mapping
from pathlib import Path

import files_by_hand as by_hand
import numpy as np
import OpenImageIO
import pytest
from numpy.typing import NDArray

from vrlf.errors import ImageReadError
from vrlf.images import read_channels, read_picture, srgb_decode

PICTURE = by_hand.asymmetric()
LIGHT = srgb_decode(PICTURE / 255).astype(np.float32)


def put(path: Path, data: bytes) -> Path:
    path.write_bytes(data)
    return path


def write_oiio(
    path: Path,
    pixels: NDArray[np.generic],
    attributes: Mapping[str, object] | None = None,
    channels: tuple[str, ...] = (),
) -> Path:
    """For formats too rich to be put together by hand."""
    kind = {"float32": "float", "float16": "half", "float64": "double"}.get(
        str(pixels.dtype), str(pixels.dtype)
    )
    spec = OpenImageIO.ImageSpec(pixels.shape[1], pixels.shape[0], pixels.shape[2], kind)
    if channels:
        spec.channelnames = channels
    spec.attribute("tiff:write_exif", 0)
    for name, value in (attributes or {}).items():
        if hasattr(spec, name):
            setattr(spec, name, value)
        else:
            spec.attribute(name, value)
    output = OpenImageIO.ImageOutput.create(str(path))
    assert output.open(str(path), spec), output.geterror()
    assert output.write_image(np.ascontiguousarray(pixels)), output.geterror()
    assert output.close(), output.geterror()
    return path


def refusal(path: str | os.PathLike[str]) -> str:
    with pytest.raises(ImageReadError) as caught:
        read_picture(path)
    message = str(caught.value)
    assert "\n" not in message
    assert caught.value.exit_code == 2
    return message


# --- upright and unmirrored ---------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "data"),
    [
        ("binary.ppm", by_hand.ppm(PICTURE)),
        ("text.ppm", by_hand.ppm_text(PICTURE)),
        ("deep.ppm", by_hand.ppm_16(PICTURE)),
        ("up.bmp", by_hand.bmp(PICTURE)),
        ("down.bmp", by_hand.bmp(PICTURE, top_down=True)),
        ("bl.tga", by_hand.tga(PICTURE, from_top=False, from_right=False)),
        ("tl.tga", by_hand.tga(PICTURE, from_top=True, from_right=False)),
        ("br.tga", by_hand.tga(PICTURE, from_top=False, from_right=True)),
        ("tr.tga", by_hand.tga(PICTURE, from_top=True, from_right=True)),
        ("plain.png", by_hand.png(PICTURE)),
        ("deep.png", by_hand.png(PICTURE.astype(np.uint16) * 257)),
    ],
)
def test_integer_formats_come_upright_and_exact(tmp_path: Path, name: str, data: bytes) -> None:
    picture = read_picture(put(tmp_path / name, data))
    assert picture.dtype == np.float32
    assert picture.flags.c_contiguous
    assert np.array_equal(picture, LIGHT)


@pytest.mark.parametrize("big_endian", [False, True])
def test_pfm_comes_upright_and_linear(tmp_path: Path, big_endian: bool) -> None:
    picture = read_picture(put(tmp_path / "a.pfm", by_hand.pfm(LIGHT, big_endian=big_endian)))
    assert np.array_equal(picture, LIGHT)


@pytest.mark.parametrize(
    ("resolution", "raster"),
    [
        ("-Y 5 +X 7", PICTURE),
        ("-Y 5 -X 7", PICTURE[:, ::-1]),
        ("+Y 5 +X 7", PICTURE[::-1]),
        ("+Y 5 -X 7", PICTURE[::-1, ::-1]),
        ("+X 7 -Y 5", PICTURE.swapaxes(0, 1)),
        ("-X 7 -Y 5", PICTURE[:, ::-1].swapaxes(0, 1)),
        ("+X 7 +Y 5", PICTURE[::-1].swapaxes(0, 1)),
        ("-X 7 +Y 5", PICTURE[::-1, ::-1].swapaxes(0, 1)),
    ],
)
def test_radiance_pictures_come_upright(
    tmp_path: Path, resolution: str, raster: NDArray[np.uint8]
) -> None:
    # Radiance: the first axis is the slow one; -Y runs down, +X to the right. No byte of
    # the first pixel may look like the run-length mark (2, 2, ...), which 20, 10 does not.
    picture = read_picture(put(tmp_path / "a.hdr", by_hand.hdr(raster, resolution)))
    assert np.array_equal(picture, (PICTURE / 256).astype(np.float32))


STORED_FOR_ORIENTATION = {
    1: PICTURE,
    2: PICTURE[:, ::-1],
    3: PICTURE[::-1, ::-1],
    4: PICTURE[::-1],
    5: PICTURE.swapaxes(0, 1),
    # 6: the stored row 0 is the picture's right side, the stored column 0 its top.
    6: PICTURE[:, ::-1].swapaxes(0, 1),
    7: PICTURE[::-1, ::-1].swapaxes(0, 1),
    # 8: the stored row 0 is the picture's left side, the stored column 0 its bottom.
    8: PICTURE[::-1].swapaxes(0, 1),
}


@pytest.mark.parametrize("orientation", range(1, 9))
@pytest.mark.parametrize("ending", ["png", "tif"])
def test_exif_orientation_is_honoured(tmp_path: Path, orientation: int, ending: str) -> None:
    stored = STORED_FOR_ORIENTATION[orientation]
    path = write_oiio(tmp_path / f"a.{ending}", stored, {"Orientation": orientation})
    assert np.array_equal(read_picture(path), LIGHT)


@pytest.mark.parametrize("orientation", range(1, 9))
def test_exif_orientation_of_a_jpeg(tmp_path: Path, orientation: int) -> None:
    # Blocks of 16 pixels, so that JPEG's own losses stay small beside the asymmetry.
    stored = STORED_FOR_ORIENTATION[orientation].repeat(16, axis=0).repeat(16, axis=1)
    options = {"Orientation": orientation, "compression": "jpeg:98", "jpeg:subsampling": "4:4:4"}
    picture = read_picture(write_oiio(tmp_path / "a.jpg", stored, options))
    # 0.02: a few codes of 255 from JPEG's quantisation; neighbours here differ by far more.
    assert np.allclose(picture[8::16, 8::16], LIGHT, atol=0.02)


# --- what the numbers mean ----------------------------------------------------------


def test_encoding_can_be_said(tmp_path: Path) -> None:
    path = put(tmp_path / "a.png", by_hand.png(PICTURE))
    as_linear = read_picture(path, encoding="linear")
    assert np.array_equal(as_linear, (PICTURE / 255).astype(np.float32))
    exr = write_oiio(tmp_path / "a.exr", as_linear)
    assert np.array_equal(read_picture(exr), as_linear)
    # 1e-7: float32 of a value below 1; both sides go through float64.
    assert np.allclose(read_picture(exr, encoding="srgb"), LIGHT, rtol=0, atol=1e-7)


def test_a_png_that_calls_itself_linear_is_linear(tmp_path: Path) -> None:
    gamma_1 = by_hand.png_chunk(b"gAMA", struct.pack(">I", 100_000))
    path = put(tmp_path / "a.png", by_hand.png(PICTURE, gamma_1))
    assert np.array_equal(read_picture(path), (PICTURE / 255).astype(np.float32))


def test_all_65536_codes_of_16_bits_are_exact(tmp_path: Path) -> None:
    codes = np.arange(65536, dtype=np.uint16).reshape(256, 256, 1)
    picture = read_picture(put(tmp_path / "a.png", by_hand.png(codes)))
    assert np.array_equal(picture[..., 1], srgb_decode(codes[..., 0] / 65535).astype(np.float32))


@pytest.mark.parametrize("kind", [np.float16, np.float32])
def test_float_exr_is_taken_as_it_is(tmp_path: Path, kind: type[np.floating]) -> None:
    pixels = (PICTURE / 16.0 - 3.0).astype(kind)  # below 0 and beyond 1
    assert np.array_equal(read_picture(write_oiio(tmp_path / "a.exr", pixels)), pixels)


def test_float_tiff_is_linear_and_32_bit_integers_are_not(tmp_path: Path) -> None:
    doubles = PICTURE / 255
    path = write_oiio(tmp_path / "a.tif", doubles)
    assert np.array_equal(read_picture(path), doubles.astype(np.float32))
    wide = write_oiio(tmp_path / "b.tif", PICTURE.astype(np.uint32) * 0x01010101)
    # 1e-7: the 32 bit integers pass through float32 once more than the table of 8 bits.
    assert np.allclose(read_picture(wide), LIGHT, rtol=0, atol=1e-7)


def test_grey_becomes_three_equal_channels(tmp_path: Path) -> None:
    path = put(tmp_path / "a.png", by_hand.png(PICTURE[..., :1]))
    assert np.array_equal(read_picture(path), LIGHT[..., :1].repeat(3, axis=2))


# --- alpha and channels -------------------------------------------------------------

ALPHA = (PICTURE[..., 2:] // 2 + 60).astype(np.uint8)


def test_alpha_is_composited_over_black_in_linear_light(tmp_path: Path) -> None:
    pixels = np.concatenate([PICTURE, ALPHA], axis=2)
    picture = read_picture(put(tmp_path / "a.png", by_hand.png(pixels)))
    # 1e-7: one float32 product.
    assert np.allclose(picture, LIGHT * (ALPHA / 255), rtol=0, atol=1e-7)


def test_grey_with_alpha(tmp_path: Path) -> None:
    pixels = np.concatenate([PICTURE[..., :1], ALPHA], axis=2)
    picture = read_picture(put(tmp_path / "a.png", by_hand.png(pixels)))
    expected = (LIGHT[..., :1] * (ALPHA / 255)).repeat(3, axis=2)
    assert np.allclose(picture, expected, rtol=0, atol=1e-7)  # one float32 product


def test_a_palette_with_a_transparent_colour(tmp_path: Path) -> None:
    palette = by_hand.png_chunk(b"PLTE", bytes([200, 100, 50, 10, 20, 30]))
    transparency = by_hand.png_chunk(b"tRNS", bytes([128, 255]))
    data = by_hand.png(np.array([[[0], [1]]], np.uint8), palette, transparency)
    header_of_grey, header_of_palette = (
        by_hand.png_chunk(b"IHDR", struct.pack(">IIBBBBB", 2, 1, 8, colour, 0, 0, 0))
        for colour in (0, 3)
    )
    path = put(tmp_path / "a.png", data.replace(header_of_grey, header_of_palette))
    expected = srgb_decode(np.array([[[200, 100, 50], [10, 20, 30]]]) / 255)
    expected[0, 0] *= 128 / 255
    assert np.allclose(read_picture(path), expected, rtol=0, atol=1e-7)  # one float32 product


def test_integers_that_are_premultiplied_already(tmp_path: Path) -> None:
    """As a TIFF with associated alpha: multiplied in sRGB, so undone there first."""
    alpha = np.full((*PICTURE.shape[:2], 1), 51, np.uint8)  # a fifth
    fifth = PICTURE // 5
    path = write_oiio(tmp_path / "a.tif", np.concatenate([fifth, alpha], axis=2))
    expected = srgb_decode(fifth * 5 / 255) / 5
    assert np.allclose(read_picture(path), expected, rtol=0, atol=1e-7)  # float32


def test_exr_light_is_premultiplied_and_stays(tmp_path: Path) -> None:
    pixels = np.concatenate([LIGHT, np.full_like(LIGHT[..., :1], 0.25)], axis=2)
    path = write_oiio(tmp_path / "a.exr", pixels, channels=("R", "G", "B", "A"))
    assert np.array_equal(read_picture(path), LIGHT)


def test_further_channels_are_left_out(tmp_path: Path) -> None:
    depth = np.full_like(LIGHT[..., :1], 7.0)
    pixels = np.concatenate([depth, LIGHT[..., ::-1], depth], axis=2)
    path = write_oiio(tmp_path / "a.exr", pixels, channels=("Z", "B", "G", "R", "id"))
    assert np.array_equal(read_picture(path), LIGHT)


def test_channels_that_are_no_colours(tmp_path: Path) -> None:
    path = write_oiio(tmp_path / "a.exr", LIGHT[..., :2], channels=("P", "S"))
    assert "channels P, S" in refusal(path)
    channels = read_channels(path)
    assert list(channels) == ["P", "S"]
    assert np.array_equal(channels["S"], LIGHT[..., 1])


def test_channels_of_an_integer_picture_are_refused(tmp_path: Path) -> None:
    path = put(tmp_path / "a.png", by_hand.png(PICTURE))
    with pytest.raises(ImageReadError, match="found uint8 values"):
        read_channels(path)


def test_an_exr_fills_its_display_window(tmp_path: Path) -> None:
    window = {"x": -1, "y": 2, "full_x": 0, "full_y": 0, "full_width": 9, "full_height": 6}
    picture = read_picture(write_oiio(tmp_path / "a.exr", LIGHT, window))
    expected = np.zeros((6, 9, 3), np.float32)
    expected[2:6, 0:6] = LIGHT[:4, 1:]  # a column hangs out at the left, a row below
    assert np.array_equal(picture, expected)


# --- refusals -----------------------------------------------------------------------


def test_missing_folder_and_pipe(tmp_path: Path) -> None:
    message = refusal(tmp_path / "no.png")
    assert "no.png" in message
    assert "no such file" in message
    assert "found a folder" in refusal(tmp_path)
    os.mkfifo(tmp_path / "pipe.png")
    assert "found a device or pipe" in refusal(tmp_path / "pipe.png")
    assert "Not a directory" in refusal(put(tmp_path / "f", b"x") / "a.png")
    assert "too long" in refusal(tmp_path / ("a" * 300 + ".png"))


def test_names_that_openimageio_misreads(tmp_path: Path) -> None:
    put(tmp_path / "a.png", by_hand.png(PICTURE))
    assert "NUL character" in refusal(f"{tmp_path}/a.png\0.exr")
    assert "no such file" in refusal("made-up.null?RES=10x10")
    assert "no readable picture" in refusal(put(tmp_path / "a.null", b"x"))
    assert "not UTF-8" in refusal(put(tmp_path / os.fsdecode(b"\xff.png"), b"x"))
    asked = put(tmp_path / "what? 100%04d #é.png", by_hand.png(PICTURE))
    assert np.array_equal(read_picture(asked), LIGHT)


@pytest.mark.parametrize("name", ["a.png", "a.jpg", "a.exr", "a.txt", "none"])
@pytest.mark.parametrize("data", [b"", b"hello\n" * 50, bytes(range(256))])
def test_what_is_no_picture(tmp_path: Path, name: str, data: bytes) -> None:
    message = refusal(put(tmp_path / name, data))
    assert name in message
    assert "wanted a whole picture" in message


@pytest.mark.parametrize("part", [0.3, 0.7, 0.9])
@pytest.mark.parametrize("ending", ["png", "jpg", "tif", "webp", "bmp", "ppm", "exr", "hdr"])
def test_truncated_files(
    tmp_path: Path, ending: str, part: float, capfd: pytest.CaptureFixture[str]
) -> None:
    noise = np.random.default_rng(7).integers(0, 256, (60, 80, 3)).astype(np.uint8)
    pixels = noise.astype(np.float32) if ending in ("exr", "hdr") else noise
    path = write_oiio(tmp_path / f"a.{ending}", pixels)
    whole = path.read_bytes()
    path.write_bytes(whole[: int(len(whole) * part)])
    refusal(path)
    assert capfd.readouterr().err == ""  # libpng would have had its say


def test_a_flipped_bit_in_a_png(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    data = bytearray(by_hand.png(PICTURE))
    data[60] ^= 4
    assert "damaged PNG" in refusal(put(tmp_path / "a.png", bytes(data)))
    assert capfd.readouterr().err == ""


@pytest.mark.parametrize(
    ("name", "data"),
    [
        ("a.png", by_hand.png_header(65535, 65535)),
        ("a.bmp", by_hand.bmp_header(65535, 65535)),
        ("a.bmp", by_hand.bmp_header(16000, 16000)),  # 732 MiB, each side within the limit
        ("a.ppm", b"P6\n65535 65535\n255\n".ljust(74, b"x")),
        ("a.ppm", b"P6\n16000 16000\n65535\n".ljust(74, b"x")),
        ("a.hdr", b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 65535 +X 65535\n".ljust(74, b"x")),
        (
            "a.tga",
            struct.pack("<BBBHHBHHHHBB", 0, 0, 2, 0, 0, 0, 0, 0, 65535, 65535, 24, 0) + b"x" * 56,
        ),
    ],
)
def test_small_files_that_claim_a_huge_picture(tmp_path: Path, name: str, data: bytes) -> None:
    assert len(data) <= 74
    assert "wanted" in refusal(put(tmp_path / name, data))


@pytest.mark.parametrize("side_px", [16000, 65535])
def test_a_tiff_that_claims_a_huge_picture(tmp_path: Path, side_px: int) -> None:
    path = write_oiio(tmp_path / "a.tif", PICTURE)
    data = path.read_bytes()
    for tag in (256, 257):  # width and height, one SHORT each; the last directory counts
        entry = struct.pack("<HHI", tag, 3, 1)
        value_at = data.rindex(entry) + len(entry)
        data = data[:value_at] + struct.pack("<H", side_px) + data[value_at + 2 :]
    assert "wanted at most 16384 pixels a side and 512 MiB" in refusal(put(path, data))


@pytest.mark.parametrize(("width", "height"), [(0, 5), (5, 0), (0, 0)])
def test_pictures_of_no_size(
    tmp_path: Path, width: int, height: int, capfd: pytest.CaptureFixture[str]
) -> None:
    message = refusal(put(tmp_path / "a.png", by_hand.png_header(width, height)))
    assert f"{width}x{height}" in message
    refusal(put(tmp_path / "a.ppm", f"P6\n{width} {height}\n255\n".encode()))
    assert capfd.readouterr().err == ""


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_light_that_is_not_finite(tmp_path: Path, bad: float) -> None:
    pixels = LIGHT.copy()
    pixels[3, 2, 1] = pixels[4, 0, 0] = bad
    message = refusal(write_oiio(tmp_path / "a.exr", pixels))
    assert "found 2 values" in message
    assert "row 3, column 2" in message


def test_doubles_beyond_float32_are_not_finite(tmp_path: Path) -> None:
    assert "infinite" in refusal(write_oiio(tmp_path / "a.tif", np.full((2, 2, 3), 1e300)))


def test_signed_integers_are_refused(tmp_path: Path) -> None:
    path = write_oiio(tmp_path / "a.tif", PICTURE.astype(np.int16))
    assert "found int16 values" in refusal(path)


def test_a_refusal_leaves_nothing_behind_for_the_next_file(tmp_path: Path) -> None:
    refusal(put(tmp_path / "bad.jpg", b"\xff\xd8\xff\xe0 nonsense"))
    good = put(tmp_path / "good.png", by_hand.png(PICTURE))
    assert np.array_equal(read_picture(good), LIGHT)
