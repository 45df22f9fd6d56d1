"""Films: the frame of each time, both ways; colours; damage; and what is written comes back."""

from __future__ import annotations

import errno
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from films_by_hand import frame_codes, make_film

from vrlf.content import video
from vrlf.content.video import Film, FilmWriter
from vrlf.errors import ImageReadError, OutputError, OutputPathError


def test_the_frame_of_a_time(tmp_path: Path) -> None:
    film = Film(make_film(tmp_path / "plain.mkv", 30), layout="mono")
    assert (film.size_px, film.rate_hz) == ((48, 20), 25.0)
    assert film.duration_s == pytest.approx(30 / 25, abs=0.05)
    # Onward, back, far ahead, between two frames, before the beginning, after the end.
    for index in (0, 1, 2, 7, 3, 28, 0, 29, 14):
        for late in (0.0, 0.6):
            left, right = film.at((index + late) / 25)
            np.testing.assert_array_equal(left, frame_codes(index))
            assert right is left
            assert film.is_same((index + 0.3) / 25)
    np.testing.assert_array_equal(film.at(-3.0)[0], frame_codes(0))
    np.testing.assert_array_equal(film.at(99.0)[0], frame_codes(29))
    film.release()


def test_frames_count_by_their_times_not_by_their_number(tmp_path: Path) -> None:
    film = Film(make_film(tmp_path / "uneven.mkv", 4, times=[0, 3, 20, 90]), layout="mono")
    for tick, index in ((0, 0), (2, 0), (3, 1), (19, 1), (20, 2), (89, 2), (90, 3), (5, 1)):
        np.testing.assert_array_equal(film.at(tick / 25)[0], frame_codes(index))
    film.release()


def test_a_seek_ends_on_the_very_frame(tmp_path: Path) -> None:
    """Key frames are rare, frames refer to later ones."""
    path = tmp_path / "seek.mp4"
    make_film(path, 200, codec="libx264rgb", pixels="bgr24", crf="0", g="60", bf="2")
    film = Film(path, layout="mono")
    for index in (150, 20, 199, 61, 59, 60, 0, 120, 119):
        np.testing.assert_array_equal(film.at(index / 25 + 0.01)[0], frame_codes(index))
    film.release()


@pytest.mark.parametrize(
    ("name", "layout", "swapped", "left", "right"),
    [
        ("a_sbs.mkv", "auto", False, np.s_[:, :24], np.s_[:, 24:]),
        ("a_ou.mkv", "auto", False, np.s_[:10], np.s_[10:]),
        ("a.mkv", "auto", False, np.s_[:], np.s_[:]),
        ("a.mkv", "side-by-side", True, np.s_[:, 24:], np.s_[:, :24]),
    ],
)
def test_each_eyes_part(
    tmp_path: Path, name: str, layout: str, swapped: bool, left: Any, right: Any
) -> None:
    made = make_film(tmp_path / name, 2, size_px=(48, 20), picture=lambda k, s: frame_codes(k, s))
    if name == "a.mkv" and layout == "auto":  # 48 x 20 is as wide as 2.4 to 1, no more
        assert Film(made).layout == "mono"
    film = Film(made, layout=layout, cross_eyed=swapped)
    found = film.at(0.04)
    np.testing.assert_array_equal(found[0], frame_codes(1)[left])
    np.testing.assert_array_equal(found[1], frame_codes(1)[right])
    film.release()


@pytest.mark.parametrize("height", [160, 720])
def test_an_untagged_films_matrix_goes_by_its_height(tmp_path: Path, height: int) -> None:
    """BT.601 below 720 rows, BT.709 from there on; the wrong one would be off by 10 and more."""
    import av

    wanted = (200, 30, 90)
    matrix = "ITU709" if height >= 720 else "ITU601"
    path = tmp_path / "even.mkv"
    with av.open(str(path), "w") as container:
        stream: Any = container.add_stream("libx264", rate=25)
        stream.width, stream.height, stream.pix_fmt = 64, height, "yuv420p"
        stream.options = {"crf": "1"}
        codes = np.full((height, 64, 3), wanted, np.uint8)
        frame = av.VideoFrame.from_ndarray(codes, format="rgb24")
        frame = frame.reformat(format="yuv420p", dst_colorspace=matrix)
        frame.colorspace = 2
        container.mux(stream.encode(frame))
        container.mux(stream.encode())
    film = Film(path, layout="mono")
    # Eight bits of luma and chroma in the limited range: two codes.
    assert np.abs(film.at(0.0)[0].astype(int) - wanted).max() <= 3
    film.release()


@pytest.mark.parametrize("kept", [0.3, 0.7])
@pytest.mark.parametrize("ending", [".mkv", ".avi"])
def test_of_a_truncated_film_what_is_whole_is_shown(
    tmp_path: Path, kept: float, ending: str
) -> None:
    whole = make_film(tmp_path / f"whole{ending}", 60)
    cut = tmp_path / f"cut{ending}"
    raw = whole.read_bytes()
    cut.write_bytes(raw[: int(len(raw) * kept)])
    film = Film(cut, layout="mono")
    np.testing.assert_array_equal(film.at(0.1)[0], frame_codes(2))
    last = film.at(2.3)[0]
    index = next(k for k in range(60) if np.array_equal(last, frame_codes(k)))
    assert abs(index - 60 * kept) < 6
    np.testing.assert_array_equal(film.at(0.0)[0], frame_codes(0))
    np.testing.assert_array_equal(film.at(2.3)[0], last)
    if ending == ".mkv":
        assert film.fault is not None
        assert "\n" not in film.fault
    film.release()


@pytest.mark.parametrize(
    "content",
    [b"", b"no film at all" * 50, b"\x1aE\xdf\xa3" + bytes(200)],
    ids=["0", "text", "ebml"],
)
def test_what_is_no_film_is_one_line(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "no.mkv"
    path.write_bytes(content)
    with pytest.raises(ImageReadError, match=r"no\.mkv: found") as caught:
        Film(path)
    assert "\n" not in str(caught.value)
    with pytest.raises(ImageReadError, match=r"none\.mkv: found"):
        Film(tmp_path / "none.mkv")


def test_what_is_written_comes_back_byte_for_byte(tmp_path: Path) -> None:
    path = tmp_path / "made.mkv"
    size = (51, 23)  # odd both ways
    with FilmWriter(path, size, 23.976) as film:
        for index in range(5):
            film.add(frame_codes(index, size))
    assert [each.name for each in tmp_path.iterdir()] == ["made.mkv"]
    back = Film(path, layout="mono")
    assert back.rate_hz == pytest.approx(23.976, abs=0.01)
    for index in range(5):
        np.testing.assert_array_equal(back.at((index + 0.1) / 23.976)[0], frame_codes(index, size))
    back.release()


def test_a_failed_write_leaves_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "made.mkv"
    path.write_bytes(b"older")

    def full(*_: Any) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    def interrupted() -> None:
        with FilmWriter(path, (8, 8), 25.0) as film:
            film.add(frame_codes(0, (8, 8)))
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    film = FilmWriter(path, (8, 8), 25.0)
    monkeypatch.setattr(video.os, "replace", full)
    film.add(frame_codes(0, (8, 8)))
    with pytest.raises(OutputError, match="No space left"):
        film.finish()
    assert [each.name for each in tmp_path.iterdir()] == ["made.mkv"]
    assert path.read_bytes() == b"older"
    with pytest.raises(OutputPathError, match="no folder"):
        FilmWriter(tmp_path / "no" / "made.mkv", (8, 8), 25.0)


@pytest.mark.parametrize("rate_hz", [24.0, 30.0, 60.0, 30000 / 1001])
def test_each_frame_is_shown_at_its_own_time(tmp_path: Path, rate_hz: float) -> None:
    """Matroska rounds times to a millisecond: none is skipped and none shown twice for that."""
    path = tmp_path / "made.mkv"
    with FilmWriter(path, (16, 8), rate_hz) as film:
        for index in range(40):
            film.add(frame_codes(index, (16, 8)))
    back = Film(path, layout="mono")
    for index in (*range(40), 7, 2, 31):
        np.testing.assert_array_equal(back.at(index / rate_hz)[0], frame_codes(index, (16, 8)))
        assert back.is_same(index / rate_hz)
    back.release()


def test_a_film_that_changes_its_size_ends_there(tmp_path: Path) -> None:
    """Two streams of one format, one behind the other: MPEG-1 lets a sequence follow another."""
    first = make_film(tmp_path / "a.mpg", 10, codec="mpeg1video", pixels="yuv420p")
    second = make_film(
        tmp_path / "b.mpg", 10, codec="mpeg1video", pixels="yuv420p", size_px=(64, 32)
    )
    both = tmp_path / "both.mpg"
    both.write_bytes(first.read_bytes() + second.read_bytes())
    film = Film(both, layout="mono")
    for time_s in (0.0, 0.2, 0.5, 0.9):
        assert film.at(time_s)[0].shape == (20, 48, 3)
    assert film.fault is not None
    assert "another size, 64x32," in film.fault
    film.release()
