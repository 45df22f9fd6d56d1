"""Frames of one wearer: what a renderer computes, tables that swap whole, nothing that grows."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import Any

import numpy as np
import pass_rigs
import pytest
from numpy.typing import NDArray

from vrlf.errors import InputError
from vrlf.gpu import Device, Texture
from vrlf.model import Rig
from vrlf.passes import phases
from vrlf.renderer import GpuRenderer, Stream, bare_rig
from vrlf.renderer.making import Made, Part, at_once, making

Light = NDArray[Any]
RAYS = 16

# Two different eyes, an odd width, a turned lattice off the centre.
FIRST = pass_rigs.SMALL["coma-lenslets"]
OTHER = FIRST.model_copy(
    update={"left": FIRST.left.model_copy(update={"sphere_d": -3.75, "axis_deg": 65.0})}
)


def with_method(rig: Rig, method: str, **changes: Any) -> Rig:
    """The rig with another prefilter."""
    given = rig.prefilter.model_copy(update={"method": method, **changes})
    return rig.model_copy(update={"prefilter": given})


@pytest.fixture(autouse=True)
def _few_rays(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nothing here depends on how good the operator's tables are."""
    monkeypatch.setattr(phases, "_RAYS_AN_EYE", 1 << 18)


@pytest.fixture(scope="module")
def renderer() -> Iterator[GpuRenderer]:
    """On a device of its own: its tables outlive a test."""
    with GpuRenderer() as made:
        yield made


def light_of(texture: Texture) -> Light:
    """Its colours."""
    return np.asarray(texture.read()[..., :3])


def frame(stream: Stream, seed: int) -> tuple[Rig, Light, Light]:
    """A whole frame: the rig it belongs to, the panel image, what is seen."""
    rig = stream.begin()
    stream.target.write(pass_rigs.picture(rig, seed))
    stream.show()
    stream.look()
    return rig, light_of(stream.panel), light_of(stream.seen)


def finish(stream: Stream) -> None:
    """Begin frames until the prescription that is wanted has come."""
    while stream.is_changing:
        stream.begin()


def expected(renderer: GpuRenderer, rig: Rig, seed: int) -> tuple[Light, Light]:
    """The same by the renderer."""
    panel = renderer.prefilter(pass_rigs.picture(rig, seed), rig)
    return panel, renderer.perceive(panel, rig, rays=RAYS)


@pytest.mark.parametrize("method", ["forward", "none", "optimal"])
def test_a_frame_is_what_the_renderer_computes(
    renderer: GpuRenderer, device: Device, method: str
) -> None:
    rig = with_method(FIRST, method, iterations=3)
    with Stream(device, rig, rays=RAYS) as stream:
        given, panel, seen = frame(stream, seed=4)
    assert given == rig
    renderer.device.make_current()
    wanted = expected(renderer, rig, seed=4)
    np.testing.assert_array_equal(panel, wanted[0])
    np.testing.assert_array_equal(seen, wanted[1])


@pytest.mark.parametrize("method", ["forward", "optimal"])
def test_each_frame_belongs_wholly_to_one_prescription(
    renderer: GpuRenderer, device: Device, method: str
) -> None:
    one, other = (with_method(rig, method, iterations=0) for rig in (FIRST, OTHER))
    frames = []
    with Stream(device, one, rays=RAYS, making_ms=1e-6) as stream:
        frames.append(frame(stream, seed=0))
        stream.change(other)
        while stream.is_changing:
            frames.append(frame(stream, seed=len(frames)))
        frames.append(frame(stream, seed=len(frames)))
    rigs = [rig for rig, _, _ in frames]
    swap = rigs.index(other)
    # One piece a frame: the making took some, in which the old one was shown.
    assert swap > 2
    assert rigs == [one] * swap + [other] * (len(rigs) - swap)
    renderer.device.make_current()
    for seed in (0, swap - 1, swap, len(frames) - 1):
        rig, panel, seen = frames[seed]
        wanted = expected(renderer, rig, seed)
        np.testing.assert_array_equal(panel, wanted[0])
        np.testing.assert_array_equal(seen, wanted[1])


def test_a_key_held_down_is_followed(device: Device) -> None:
    """Each want replaces the last one, but what is being made is shown first."""
    wants = [
        FIRST.model_copy(update={"left": FIRST.left.model_copy(update={"sphere_d": -n / 4})})
        for n in range(1, 40)
    ]
    shown = []
    with Stream(device, FIRST, making_ms=1e-6) as stream:
        for rig in wants:
            stream.change(rig)
            shown.append(stream.begin())
        while stream.is_changing:
            shown.append(stream.begin())
        last = stream.begin()
    assert last == wants[-1]
    # Some on the way, in order.
    steps = list(dict.fromkeys(rig.left.sphere_d for rig in shown))
    assert len(steps) > 4
    assert steps[1:] == sorted(steps[1:], reverse=True)


def test_settings_of_the_solver_need_no_new_tables(device: Device) -> None:
    rig = with_method(FIRST, "optimal", iterations=2)
    with Stream(device, rig) as stream:
        before = device.live_objects
        tables = stream._present["prefilter"].item
        stream.change(with_method(FIRST, "optimal", iterations=2, brightness=0.5))
        finish(stream)
        assert stream._present["prefilter"].item is tables
        assert device.live_objects == before
        stream.target.write(np.ones((*pass_rigs.picture(rig).shape[:2], 3), np.float32))
        stream.show()
        assert light_of(stream.panel).mean() < 0.7


def test_another_panel_brings_its_own_pictures(device: Device) -> None:
    bare = pass_rigs.SMALL["own-lens-bare"]
    assert bare.panel != FIRST.panel
    with Stream(device, FIRST, rays=RAYS) as stream:
        frame(stream, seed=0)
        stream.change(bare)
        finish(stream)
        rig, panel, _ = frame(stream, seed=1)
        assert rig == bare
        np.testing.assert_array_equal(panel, pass_rigs.picture(bare, 1))


def test_nothing_is_left_when_it_ends_half_way(device: Device) -> None:
    before = device.live_objects
    stream = Stream(device, with_method(FIRST, "optimal"), rays=RAYS, making_ms=1e-6)
    stream.change(with_method(OTHER, "optimal"))
    stream.begin()
    assert stream.is_changing
    stream.release()
    stream.release()
    assert device.live_objects == before


def test_what_cannot_be_made_leaves_the_old_one(
    device: Device, monkeypatch: pytest.MonkeyPatch
) -> None:
    with Stream(device, FIRST, rays=RAYS) as stream:
        _, panel, _ = frame(stream, seed=3)
        before = device.live_objects

        def refuses(*_: Any) -> Any:
            raise InputError("tables: found no memory, wanted some")

        monkeypatch.setattr("vrlf.renderer.stream.PerceiveTables", refuses)
        stream.change(OTHER)
        with pytest.raises(InputError, match="no memory"):
            finish(stream)
        assert not stream.is_changing
        assert device.live_objects == before
        rig, again, _ = frame(stream, seed=3)
        assert rig == FIRST
        np.testing.assert_array_equal(again, panel)


def test_a_panel_too_large_is_refused_when_it_is_wanted(device: Device) -> None:
    wide = FIRST.panel.model_copy(update={"width_px": device.info.max_texture_px + 2})
    with Stream(device, FIRST) as stream, pytest.raises(InputError, match="panel: found"):
        stream.change(FIRST.model_copy(update={"panel": wide}))


def test_looking_without_rays_is_refused(device: Device) -> None:
    with Stream(device, FIRST) as stream:
        stream.begin()
        stream.target.write(pass_rigs.picture(FIRST))
        stream.show()
        with pytest.raises(ValueError, match="without rays"):
            stream.look()


def test_a_hundred_frames_leave_the_same_objects(device: Device) -> None:
    with Stream(device, FIRST, rays=RAYS) as stream:
        frame(stream, seed=0)
        before = device.live_objects, device.live_bytes
        for number in range(100):
            if number % 20 == 5:
                stream.change(OTHER if number % 40 == 5 else FIRST)
            frame(stream, seed=number % 3)
        finish(stream)
        assert (sorted(device.live_objects), device.live_bytes) == (sorted(before[0]), before[1])


class Thing:
    """Counts whether it was given back."""

    def __init__(self) -> None:
        self.released = 0

    def release(self) -> None:
        self.released += 1


def test_a_making_closed_half_way_gives_back_what_it_made() -> None:
    first, second = Thing(), Thing()
    work = making([Part("a", 1, at_once(lambda: first)), Part("b", 1, at_once(lambda: second))], {})
    next(work)
    work.close()
    assert (first.released, second.released) == (1, 0)


def test_only_what_changed_is_made_and_given_back() -> None:
    kept, old, new = Thing(), Thing(), Thing()
    present = {"kept": Made(1, kept), "other": Made(1, old), "nothing": Made(1, None)}
    parts = [
        Part("kept", 1, at_once(Thing)),
        Part("other", 2, at_once(lambda: new)),
        Part("nothing", 2, at_once(lambda: None)),
    ]
    work = making(parts, present)
    while True:
        try:
            next(work)
        except StopIteration as done:
            result = done.value
            break
    whole = result.replacing(present)
    assert (whole["kept"].item, whole["other"].item) == (kept, new)
    assert (kept.released, old.released, new.released) == (0, 1, 0)


def test_a_still_picture_converges_while_it_is_watched(device: Device) -> None:
    array = pass_rigs.LENSLETS | {"rotation_deg": 11.0, "offset_um": [35.0, 90.0]}
    rig = with_method(pass_rigs.rig(113, 57, array=array), "optimal", iterations=2)
    meant = 0.2 + 0.5 * pass_rigs.picture(rig, 6)
    # Of the left eye, inside a border of the blur's radius and a lenslet.
    inner = (slice(14, -14), slice(14, 42))
    error = []
    with Stream(device, rig, rays=256) as stream:
        for _ in range(8):
            stream.begin()
            stream.target.write(meant)
            stream.show()
            stream.look()
            left = (light_of(stream.seen) - meant)[inner]
            error.append(float(np.sqrt(np.mean(left**2))))
    print(error)
    # Never worse from frame to frame, and in the end clearly better than the first, cold one.
    assert all(late <= early * 1.001 for early, late in pairwise(error))
    # (0.83 of it: the picture has noise to the pixel, which no array shows).
    assert error[-1] < 0.9 * error[0]


def test_slow_frames_give_more_time_to_what_comes(
    device: Device, monkeypatch: pytest.MonkeyPatch
) -> None:
    now = [100.0]
    monkeypatch.setattr("vrlf.renderer.stream.time.perf_counter", lambda: now[0])
    given = []

    def noted(_: Any, budget_ms: float) -> None:
        given.append(budget_ms)

    monkeypatch.setattr("vrlf.renderer.stream.advanced", noted)
    with Stream(device, FIRST) as stream:
        stream.change(OTHER)
        for own_s in (0.0, 0.010, 0.200, 0.020):
            now[0] += own_s
            stream.begin()
    # The first frame, one at 100 Hz, one at 5 Hz, a fast one again.
    assert given == pytest.approx([4.0, 4.0, 100.0, 4.0])


def test_what_is_seen_without_correction(renderer: GpuRenderer, device: Device) -> None:
    with Stream(device, FIRST, rays=RAYS, uncorrected=True) as stream:
        for rig in (FIRST, OTHER):
            stream.change(rig, at_once=True)
            assert stream.begin() == rig
            stream.target.write(pass_rigs.picture(rig, 6))
            stream.look_uncorrected()
            seen = light_of(stream.seen_uncorrected)
            renderer.device.make_current()
            wanted = renderer.perceive(pass_rigs.picture(rig, 6), bare_rig(rig), rays=RAYS)
            np.testing.assert_array_equal(seen, wanted)
            device.make_current()
    with Stream(device, FIRST, rays=RAYS) as stream:
        stream.begin()
        with pytest.raises(ValueError, match="uncorrected=True"):
            stream.look_uncorrected()


def test_what_is_wanted_at_once_is_in_the_next_frame(device: Device) -> None:
    """Whatever was being made is dropped, and leaves nothing behind."""
    slow = with_method(OTHER, "optimal", iterations=1)
    with Stream(device, FIRST, rays=RAYS, making_ms=0.0) as stream:
        before = sorted(device.live_objects)
        stream.change(slow)
        assert stream.begin() == FIRST
        assert stream.is_changing
        stream.change(OTHER, at_once=True)
        assert stream.begin() == OTHER
        assert not stream.is_changing
        stream.change(FIRST, at_once=True)
        stream.begin()
        # The compiled programs of the operator stay.
        added = [each for each in device.live_objects if each not in before]
        assert all(each.startswith("pass operator") for each in added)


def test_another_number_of_rays(renderer: GpuRenderer, device: Device) -> None:
    with Stream(device, FIRST, rays=RAYS) as stream:
        stream.change(FIRST, rays=2 * RAYS)
        finish(stream)
        _, panel, seen = frame(stream, seed=4)
        with pytest.raises(InputError, match="rays"):
            stream.change(FIRST, rays=0)
    renderer.device.make_current()
    wanted = renderer.perceive(panel, FIRST, rays=2 * RAYS)
    np.testing.assert_array_equal(seen, wanted)
