"""The plots: what they draw, where they may be put, and what is said without matplotlib."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from matplotlib.figure import Figure

from vrlf.errors import InputError, OutputPathError
from vrlf.studies import plots
from vrlf.studies.bench import Timing
from vrlf.studies.limits import Limits
from vrlf.studies.plots import check_plot, plot_quality, plot_speed
from vrlf.studies.quality import EyeQuality, Quality, QualityReport
from vrlf.studies.speed import Speed, SpeedReport


def speed_of(name: str, megapixels: float, ms: float) -> Speed:
    return Speed(Timing(name, "1x1", ms, ms, 3), megapixels, 1.0, "copy")


SPEED = SpeedReport(
    "a device",
    Limits(copy_gb_per_s=4.0, fetch_g_per_s=1.0),
    (
        # A size of which one step did not fit, and a time that a logarithm can't show.
        speed_of("forward", 0.5, 4.0),
        speed_of("optimal step", 0.5, 0.0),
        speed_of("tables optimal", 0.5, 900.0),
        speed_of("forward", 2.0, 15.0),
        speed_of("optimal step", 2.0, 30.0),
        speed_of("frame forward", 2.0, 20.0),
    ),
    (),
)


def quality_of(rig: str, picture: str, method: str, count: int | None, db: float) -> Quality:
    # The left eye is the worse one.
    return Quality(rig, picture, method, count, EyeQuality(db, 0.5), EyeQuality(db + 3.0, None))


QUALITY = QualityReport(
    "a device",
    "440x220",
    64,
    tuple(
        quality_of(rig, picture, method, count, db + more)
        for rig, more in (("one", 0.0), ("other", 1.5))
        for picture, more_still in (("a", 0.0), ("b", 4.0))
        for method, count, db in (
            ("none", None, 18.0 + more_still),
            ("forward", None, 20.0 + more_still),
            ("optimal", 0, 22.0 + more_still),
            ("optimal", 8, 26.0 + more_still),
            ("converged", None, 28.0 + more_still),
        )
    ),
)


@pytest.fixture
def drawn(monkeypatch: pytest.MonkeyPatch) -> list[Figure]:
    """The figures as they are when they are written."""
    figures: list[Figure] = []
    whole = plots._finish

    def keep(figure: Figure, axes: Any, path: Any) -> None:
        whole(figure, axes, path)
        figures.append(figure)

    monkeypatch.setattr(plots, "_finish", keep)
    return figures


def lines_of(figure: Figure) -> dict[str, list[tuple[float, float]]]:
    (axes,) = figure.axes
    return {str(line.get_label()): list(zip(*line.get_data(), strict=True)) for line in axes.lines}


def test_time_against_size_has_a_line_for_each_step_and_the_limit(
    tmp_path: Path, drawn: list[Figure]
) -> None:
    plot_speed(SPEED, tmp_path / "speed.png")
    lines = lines_of(drawn[0])
    # 32 bytes a pixel at 4 GB/s are 8 ms a megapixel.
    assert lines == {
        "forward": [(0.5, 4.0), (2.0, 15.0)],
        "optimal step": [(2.0, 30.0)],
        "frame forward": [(2.0, 20.0)],
        "copy of a picture (limit)": [(0.5, 4.0), (2.0, 16.0)],
    }
    (axes,) = drawn[0].axes
    assert (axes.get_xscale(), axes.get_yscale()) == ("log", "log")
    assert (tmp_path / "speed.png").read_bytes().startswith(b"\x89PNG")
    assert [path.name for path in tmp_path.iterdir()] == ["speed.png"]


def test_sharpness_against_steps_has_a_line_for_each_rig(
    tmp_path: Path, drawn: list[Figure]
) -> None:
    plot_quality(QUALITY, tmp_path / "quality.SVG")
    lines = lines_of(drawn[0])
    # Means over two pictures that are 4 dB apart.
    assert lines["one"] == [(0, 24.0), (8, 28.0)]
    assert lines["other"] == [(0, 25.5), (8, 29.5)]
    assert {"none", "forward", "converged"} <= set(lines)
    assert "forward + wiener" not in lines
    (axes,) = drawn[0].axes
    level = {line.get_ydata()[0] for line in axes.lines if len(line.get_ydata()) == 2}
    assert {20.0, 22.0, 30.0, 21.5, 23.5, 31.5} <= {float(each) for each in level}
    assert b"<svg" in (tmp_path / "quality.SVG").read_bytes()[:1000]


def test_more_lines_than_colours_differ_in_their_marks() -> None:
    used = [
        (plots._COLOURS[n % len(plots._COLOURS)], plots._MARKERS[n % len(plots._MARKERS)])
        for n in range(14)
    ]
    assert len(set(used)) == 14
    assert len(set(plots._MARKERS)) == len(plots._MARKERS)


@pytest.mark.parametrize("name", ["speed.pdf", "speed", "speed.png.txt"])
def test_a_wrong_ending_is_refused(tmp_path: Path, name: str) -> None:
    with pytest.raises(OutputPathError, match=r"wanted \.png or \.svg"):
        check_plot(str(tmp_path / name))


def test_a_place_that_cannot_hold_it_is_refused(tmp_path: Path) -> None:
    with pytest.raises(OutputPathError, match="found no folder"):
        check_plot(str(tmp_path / "nowhere" / "speed.png"))
    (tmp_path / "folder.png").mkdir()
    with pytest.raises(OutputPathError, match="found a folder of that name"):
        check_plot(str(tmp_path / "folder.png"))
    assert check_plot(str(tmp_path / "speed.svg")) == tmp_path / "speed.svg"


def test_without_matplotlib_it_says_what_to_install(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(plots, "find_spec", lambda _: None)
    with pytest.raises(InputError, match=r"pip install 'vrlf\[plots\]'"):
        check_plot(str(tmp_path / "speed.png"))
    assert list(tmp_path.iterdir()) == []
