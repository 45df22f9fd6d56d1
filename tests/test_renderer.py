"""A frame by the GPU's renderer and by the reference; what is kept, given back and refused."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from typing import Any

import numpy as np
import pass_rigs
import pytest
from numpy.typing import NDArray

import vrlf.renderer.gpu as renderer_module
from vrlf.content.pictures import StereoSource
from vrlf.errors import InputError
from vrlf.gpu import Device
from vrlf.model import Rig
from vrlf.optics.fitting import FitMode
from vrlf.optics.samples import MAX_POINTS
from vrlf.renderer import GpuRenderer, ReferenceRenderer

Light = NDArray[Any]

RAYS = 32
# As for the passes alone: the steps between them only copy.
SAME_LIGHT = 1e-4
EDGE_SHARE = 1e-3

REFERENCE = ReferenceRenderer()


@pytest.fixture
def gpu(device: Device) -> Iterator[GpuRenderer]:
    """A renderer on the file's device, which it leaves empty."""
    before = device.live_objects
    with GpuRenderer(device) as made:
        yield made
    assert device.live_objects == before


def source(
    left: tuple[int, int] = (31, 57),
    right: tuple[int, int] = (63, 29),
    aspect: float = 1.0,
    panel: Light | None = None,
) -> StereoSource:
    """Different random light for each eye; sizes are (width, height)."""
    rng = np.random.default_rng(7)
    pictures = [rng.random((height, width, 3), dtype=np.float32) for width, height in (left, right)]
    return StereoSource(
        left=pictures[0],
        right=pictures[1],
        layout="mono",
        pixel_for_pixel=False,
        pixel_aspect=aspect,
        panel=panel,
    )


def hold_same(got: Light, wanted: Light) -> None:
    """Equal but for the few pixels of which a ray lies on an edge."""
    assert got.dtype == wanted.dtype
    assert got.shape == wanted.shape
    error = np.abs(got.astype(np.float64) - wanted).max(axis=-1)
    apart = int((error > SAME_LIGHT).sum())
    print(f"{apart} of {error.size} pixels apart, greatest error {error.max():.1e}")
    assert apart <= EDGE_SHARE * error.size


# --- against the reference --------------------------------------------------------------------


@pytest.mark.parametrize("fit", ["contain", "cover"])
@pytest.mark.parametrize(
    "pictures",
    [
        source(),
        source(aspect=2.0),
        # 25 times too large on one axis: averaged down before the GPU filters.
        source((30, 800), (700, 40), aspect=0.5),
    ],
    ids=["plain", "half", "large"],
)
def test_targets(gpu: GpuRenderer, pictures: StereoSource, fit: FitMode) -> None:
    given = pass_rigs.rig(45, 31, headset={"distortion": [0.3, 0.5]})
    target = gpu.target(pictures, given, fit)
    assert target.dtype == np.float32
    hold_same(target, REFERENCE.target(pictures, given, fit))


def test_averaging_down_first_moves_nothing(gpu: GpuRenderer) -> None:
    """A ramp 20 times too large is the same ramp, in its place, to the pixel's average."""
    given = pass_rigs.rig(44, 30)
    x, y = np.arange(440)[None, :, None] + 0.5, np.arange(600)[:, None, None] + 0.5
    ramp = (x / 900 + y / 1300 + np.zeros(3)).astype(np.float32)
    pictures = dataclasses.replace(source(), left=ramp, right=ramp[::-1])
    at_x, at_y = np.arange(22)[None, :, None] + 0.5, np.arange(30)[:, None, None] + 0.5
    wanted = at_x * 20 / 900 + at_y * 20 / 1300 + np.zeros(3)
    shown = gpu.target(pictures, given)[:, :22]
    # The filter keeps straight lines where the kernel lies on the picture wholly.
    assert shown[2:-2, 2:-2] == pytest.approx(wanted[2:-2, 2:-2], abs=1e-5)


def test_a_source_of_the_panels_size_is_the_target(gpu: GpuRenderer) -> None:
    """Pixel for pixel, the middle column too; light beyond the panel's range is cut."""
    given = pass_rigs.rig(45, 31, headset={"distortion": [0.3, 0.5]})
    panel = pass_rigs.picture(given) * 1.5 - 0.2
    for renderer in (gpu, REFERENCE):
        assert np.array_equal(renderer.target(source(panel=panel), given), np.clip(panel, 0.0, 1.0))


NAMES = ("coma-lenslets", "round-holes-moved", "own-lens-bare", "one-chromatic-eye", "bgr-walls")


@pytest.mark.parametrize("name", NAMES)
def test_the_chain_is_the_references(gpu: GpuRenderer, name: str) -> None:
    given = pass_rigs.SMALL[name]
    target = gpu.target(source(), given, "cover")
    panel = gpu.prefilter(target, given)
    hold_same(panel, REFERENCE.prefilter(target, given))
    seen = gpu.perceive(panel, given, rays=RAYS)
    hold_same(seen, REFERENCE.perceive(panel, given, rays=RAYS))
    for dither in (False, True):
        code = gpu.encode(seen, dither=dither)
        assert code.dtype == np.uint8
        wanted = REFERENCE.encode(seen, dither=dither)
        # With dither a float32 quotient within 1e-5 of the noise decides otherwise.
        assert np.count_nonzero(code != wanted) <= (2 if dither else 0)


def test_results_are_the_callers_own(gpu: GpuRenderer) -> None:
    """Whatever a caller does to one result changes neither the input nor the next result."""
    for name in ("own-lens-bare", "coma-lenslets"):
        given = pass_rigs.SMALL[name]
        target = pass_rigs.picture(given)
        kept = target.copy()
        for step in (gpu.prefilter, gpu.perceive, REFERENCE.prefilter):
            first = step(target, given)
            wanted = first.copy()
            first[:] = 0.0
            assert np.array_equal(target, kept)
            assert np.array_equal(step(target, given), wanted)


@pytest.mark.parametrize("name", ["coma-lenslets", "own-lens-bare"])
def test_method_none_shows_the_target(gpu: GpuRenderer, name: str) -> None:
    given = with_method(pass_rigs.SMALL[name], "none")
    target = pass_rigs.picture(given)
    for renderer in (gpu, REFERENCE):
        assert np.array_equal(renderer.prefilter(target, given), target)


@pytest.mark.parametrize(
    ("name", "throughput"),
    [
        ("round-holes-moved", np.pi / 4.0 * (130.0 / 390.0) ** 2),
        ("square-holes-walls", (130.0 / 390.0) ** 2),
        ("coma-lenslets", 1.0),
        ("own-lens-bare", 1.0),
    ],
)
def test_auto_exposure_makes_up_for_the_throughput(
    gpu: GpuRenderer, name: str, throughput: float
) -> None:
    given = pass_rigs.SMALL[name]
    panel = pass_rigs.picture(given)
    for renderer in (gpu, REFERENCE):
        auto = renderer.perceive(panel, given, rays=RAYS)
        plain = renderer.perceive(panel, given, rays=RAYS, exposure="none")
        # Two float32 products in another order.
        assert plain == pytest.approx(auto * throughput, rel=1e-6, abs=1e-7)


def test_the_middle_column_is_dark(gpu: GpuRenderer) -> None:
    given = pass_rigs.SMALL["bgr-walls"]
    white = np.ones((31, 45, 3), np.float32)
    for renderer in (gpu, REFERENCE):
        assert not renderer.target(source(), given, "cover")[:, 22].any()
        assert not renderer.prefilter(white, given)[:, 22].any()
        assert not renderer.perceive(white, given, rays=8)[:, 22].any()


# --- what is kept and given back --------------------------------------------------------------


@pytest.fixture
def made(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """The names of the tables that renderers make from now on, in order."""
    names: list[str] = []
    for name in ("forward_tables", "PerceiveTables"):
        original = getattr(renderer_module, name)

        def counted(*args: Any, name: str = name, original: Any = original) -> Any:
            names.append(name)
            return original(*args)

        monkeypatch.setattr(renderer_module, name, counted)
    return names


def test_tables_are_made_once_for_a_rig(gpu: GpuRenderer, made: list[str]) -> None:
    given = pass_rigs.SMALL["coma-lenslets"]
    for seed in range(4):
        # Another object of equal content, as a caller who reads the rig again has it.
        same = Rig.model_validate(given.model_dump())
        panel = gpu.prefilter(pass_rigs.picture(given, seed), same)
        gpu.perceive(panel, same, rays=RAYS)
    assert made == ["forward_tables", "PerceiveTables"]


def test_tables_are_remade_for_another_rig(gpu: GpuRenderer, made: list[str]) -> None:
    one = pass_rigs.SMALL["coma-lenslets"]
    left = one.left.model_copy(update={"sphere_d": -4.75})
    other = one.model_copy(update={"left": left})
    picture = pass_rigs.picture(one)
    first = [gpu.prefilter(picture, each).tobytes() for each in (one, other, one)]
    assert made == ["forward_tables"] * 3
    assert first[0] == first[2]
    assert first[0] != first[1]
    seen = [gpu.perceive(picture, each, rays=RAYS).tobytes() for each in (one, other, one)]
    assert made[3:] == ["PerceiveTables"] * 3
    assert seen[0] == seen[2]
    assert seen[0] != seen[1]


def test_tables_are_remade_for_other_rays(gpu: GpuRenderer, made: list[str]) -> None:
    given = pass_rigs.SMALL["coma-lenslets"]
    picture = pass_rigs.picture(given)
    seen = [gpu.perceive(picture, given, rays=rays).tobytes() for rays in (16, 64, 64, 16)]
    assert made == ["PerceiveTables"] * 3
    assert seen[0] == seen[3]
    assert seen[1] == seen[2]
    assert seen[0] != seen[1]


def test_nothing_piles_up_and_all_is_given_back(device: Device) -> None:
    before = device.live_objects
    renderer = GpuRenderer(device)
    for name in NAMES:
        given = pass_rigs.SMALL[name]
        frame(renderer, given)
        after_first = device.live_objects
        for _ in range(3):
            frame(renderer, given)
        assert device.live_objects == after_first
    # Of the tables only the last rig's: one of each buffer.
    buffers = [label for label in device.live_objects if label.startswith("buffer rays")]
    assert len(buffers) == 1
    assert not any(label.startswith("texture") for label in device.live_objects)
    renderer.release()
    assert device.live_objects == before
    # The device was lent: it still works, also for the next renderer.
    with GpuRenderer(device) as next_one:
        frame(next_one, pass_rigs.SMALL["coma-lenslets"])
    assert device.live_objects == before


def frame(renderer: GpuRenderer, given: Rig) -> None:
    """All steps once."""
    target = renderer.target(source(), given)
    seen = renderer.perceive(renderer.prefilter(target, given), given, rays=8)
    renderer.encode(seen)


def test_textures_go_back_when_a_step_fails(
    gpu: GpuRenderer, device: Device, monkeypatch: pytest.MonkeyPatch
) -> None:
    given = pass_rigs.SMALL["coma-lenslets"]
    frame(gpu, given)
    before = device.live_objects

    def fails(*_: Any, **__: Any) -> None:
        raise RuntimeError("broken")

    for step in ("_prepare", "_forward", "_perceive", "_encode"):
        monkeypatch.setattr(getattr(gpu, step), "run", fails)
    picture = pass_rigs.picture(given)
    calls = [
        lambda: gpu.target(source(), given),
        lambda: gpu.prefilter(picture, given),
        lambda: gpu.perceive(picture, given, rays=8),
        lambda: gpu.encode(picture),
    ]
    for call in calls:
        with pytest.raises(RuntimeError, match="broken"):
            call()
        assert device.live_objects == before


def test_a_renderer_without_a_device_owns_one() -> None:
    with GpuRenderer() as own:
        given = pass_rigs.SMALL["own-lens-bare"]
        frame(own, given)
        own_device = own.device
    assert own_device.live_objects == ()
    with pytest.raises(Exception, match="released"):
        own_device.check("anything")


def test_two_renderers_take_turns(device: Device) -> None:
    """Each makes its own context current: another one's calls between do not matter.

    Nor does its end, though OpenGL's objects are numbers that both contexts use.
    """
    given = pass_rigs.SMALL["coma-lenslets"]
    picture = pass_rigs.picture(given)
    with GpuRenderer(device) as one:
        wanted = one.prefilter(picture, given).tobytes()
        with GpuRenderer() as other:
            for renderer in (other, one, other, one):
                assert renderer.prefilter(picture, given).tobytes() == wanted
        assert one.prefilter(picture, given).tobytes() == wanted


# --- what is refused --------------------------------------------------------------------------


def with_method(given: Rig, method: str) -> Rig:
    prefilter = given.prefilter.model_copy(update={"method": method})
    return given.model_copy(update={"prefilter": prefilter})


def one_line(error: BaseException) -> str:
    text = str(error)
    assert "\n" not in text
    assert "found" in text
    assert "wanted" in text
    return text


GIVEN = pass_rigs.SMALL["coma-lenslets"]  # 44 x 30
BAD_IMAGES: list[tuple[Any, list[str]]] = [
    (np.zeros((30, 44)), ["30x44", "30x44x3"]),
    (np.zeros((44, 30, 3)), ["44x30x3", "30x44x3"]),
    (np.zeros((30, 44, 4)), ["30x44x4"]),
    (np.zeros((31, 44, 3)), ["31x44x3"]),
    (1.0, ["a single number", "30x44x3"]),
    ([], ["30x44x3"]),
    ([[1.0], [1.0, 2.0]], ["no array of numbers"]),
    ("panel.png", ["no array of numbers"]),
    (None, ["wanted"]),
    (np.full((30, 44, 3), np.nan), ["3960 values", "finite"]),
    (np.pad([[[np.inf]]], ((0, 29), (0, 43), (2, 0))), ["1 value", "finite"]),
]


@pytest.mark.parametrize(("image", "words"), BAD_IMAGES, ids=range(len(BAD_IMAGES)))
def test_pictures_that_do_not_fit(gpu: GpuRenderer, image: Any, words: list[str]) -> None:
    for renderer in (gpu, REFERENCE):
        for step, what in ((renderer.prefilter, "target"), (renderer.perceive, "panel image")):
            with pytest.raises(InputError) as caught:
                step(image, GIVEN)
            text = one_line(caught.value)
            assert all(word in text for word in [*words, what])


@pytest.mark.parametrize("rays", [0, -3, MAX_POINTS + 1])
def test_rays_that_mean_nothing(gpu: GpuRenderer, rays: int) -> None:
    for renderer in (gpu, REFERENCE):
        with pytest.raises(InputError) as caught:
            renderer.perceive(pass_rigs.picture(GIVEN), GIVEN, rays=rays)
        assert str(rays) in one_line(caught.value)


def test_one_ray_is_enough(gpu: GpuRenderer) -> None:
    panel = pass_rigs.picture(GIVEN)
    hold_same(gpu.perceive(panel, GIVEN, rays=1), REFERENCE.perceive(panel, GIVEN, rays=1))


def test_a_panel_too_large_for_the_gpu(
    gpu: GpuRenderer, device: Device, monkeypatch: pytest.MonkeyPatch
) -> None:
    # Larger GPUs take 32768, which no rig exceeds: all are given the smaller ones' limit.
    limit = min(16384, device.info.max_texture_px)
    monkeypatch.setattr(device, "info", dataclasses.replace(device.info, max_texture_px=limit))
    frame(gpu, GIVEN)
    before = device.live_objects
    for width, height in ((limit + 2, 2), (2, limit + 1)):
        given = pass_rigs.rig(width, height, array=pass_rigs.LENSLETS)
        picture = np.zeros((height, width, 3), np.float32)
        calls = [
            lambda given=given: gpu.target(source(), given),
            lambda given=given, picture=picture: gpu.prefilter(picture, given),
            lambda given=given, picture=picture: gpu.perceive(picture, given, rays=1),
        ]
        for call in calls:
            with pytest.raises(InputError) as caught:
                call()
            text = one_line(caught.value)
            assert f"{width}x{height}" in text
            assert str(limit) in text
    with pytest.raises(InputError, match=str(limit)):
        gpu.encode(np.zeros((1, limit + 1, 3), np.float32))
    assert device.live_objects == before
