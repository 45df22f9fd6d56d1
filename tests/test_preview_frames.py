"""What the window shows of a session, without a window: held to what the commands compute."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pass_rigs
import pytest
from live_by_hand import Known, light_at
from numpy.typing import NDArray

from vrlf.app.preview.frames import Frames, Moment
from vrlf.app.preview.layout import Placed, loupe, placed, tile_under
from vrlf.app.preview.pacing import Effort
from vrlf.app.preview.session import Session
from vrlf.errors import InputError
from vrlf.evaluation.measure import likeness
from vrlf.gpu import Device
from vrlf.model import Rig, load_rig
from vrlf.optics.tile import BACKGROUND_CODE, GREY_CODE
from vrlf.optics.viewport import SIDES
from vrlf.passes import phases
from vrlf.reference import alignment as twin
from vrlf.reference.encode import encode
from vrlf.reference.show import show_tile
from vrlf.renderer import GpuRenderer, bare_rig
from vrlf.scene import HeadPose
from vrlf.solve import optimal
from vrlf.studies.quality import cropped

RAYS = 16
RIG = pass_rigs.SMALL["coma-lenslets"]
OTHER = RIG.model_copy(update={"left": RIG.left.model_copy(update={"sphere_d": -3.0})})
WINDOW = (RIG.panel.width_px, RIG.panel.height_px)


@pytest.fixture(scope="module")
def renderer() -> Iterator[GpuRenderer]:
    with GpuRenderer() as made:
        yield made


@pytest.fixture(autouse=True)
def _few_rays(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(phases, "_RAYS_AN_EYE", 1 << 18)


def fresh(**given: Any) -> Session:
    return replace(Session(rig=RIG, loaded=RIG), **given)


def with_method(rig: Rig, method: str, **changes: Any) -> Rig:
    given = rig.prefilter.model_copy(update={"method": method, **changes})
    return rig.model_copy(update={"prefilter": given})


def settle(frames: Frames, session: Session, moment: Moment = Moment()) -> NDArray[Any]:  # noqa: B008
    """Frames until nothing changes any more; what the window then shows, row 0 at the top."""
    frames.want(session.rig)
    tiles = placed(session, WINDOW)
    for _ in range(2000):
        if not frames.draw(tiles, WINDOW, moment):
            break
    else:
        raise AssertionError("the frames never came to rest")
    return np.asarray(frames.canvas.read()[::-1, :, :3])


def wanted(renderer: GpuRenderer, view: str, rig: Rig = RIG) -> NDArray[Any]:
    """The same picture by the commands' renderer, linear light."""
    target = light_at(rig)
    if view == "target":
        return target
    if view == "uncorrected":
        return renderer.perceive(target, bare_rig(rig), rays=RAYS)
    panel = renderer.prefilter(target, rig)
    return panel if view == "panel" else renderer.perceive(panel, rig, rays=RAYS)


@pytest.mark.parametrize("view", ["panel", "perceived", "uncorrected", "target"])
def test_a_view_has_the_codes_that_the_commands_write(
    device: Device, renderer: GpuRenderer, view: Any
) -> None:
    frames = Frames(device, RIG, Known(), rays=RAYS)
    codes = settle(frames, fresh(view=view))
    frames.release()
    renderer.device.make_current()
    np.testing.assert_array_equal(codes, renderer.encode(wanted(renderer, view)))


def test_a_change_is_in_the_next_frame_and_the_other_eye_stays(
    device: Device, renderer: GpuRenderer
) -> None:
    frames = Frames(device, RIG, Known(), rays=RAYS)
    before = settle(frames, fresh())
    frames.want(OTHER)
    frames.draw(placed(fresh(), WINDOW), WINDOW, Moment())
    assert frames.rig.left == OTHER.left
    after = settle(frames, fresh(rig=OTHER))
    frames.release()
    half, first = WINDOW[0] // 2, WINDOW[0] - WINDOW[0] // 2
    assert (after[:, :half] != before[:, :half]).any()
    np.testing.assert_array_equal(after[:, first:], before[:, first:])
    renderer.device.make_current()
    np.testing.assert_array_equal(after, renderer.encode(wanted(renderer, "perceived", OTHER)))


def test_nothing_is_computed_twice(device: Device) -> None:
    live = Known()
    frames = Frames(device, RIG, live, rays=RAYS)
    settle(frames, fresh())
    settle(frames, fresh(view="target"))
    settle(frames, fresh(rig=OTHER), Moment(time_s=3.0))
    assert live.drawn == 1, "neither a view, a prescription nor the time redraws a still"
    moving = Known(is_still=False)
    frames.show_instead(moving)
    for time_s in (0.0, 0.5, 0.5):
        frames.draw(placed(fresh(), WINDOW), WINDOW, Moment(time_s))
    assert moving.drawn == 2, "a scene that was stopped is drawn once"
    frames.draw(placed(fresh(), WINDOW), WINDOW, Moment(0.5, HeadPose(yaw_deg=3.0)))
    assert moving.drawn == 3
    frames.release()


def test_forward_stands_in_for_optimal_with_the_new_prescription(device: Device) -> None:
    rig = with_method(OTHER, "optimal", iterations=2)
    frames = Frames(device, RIG, Known(), rays=RAYS)
    frames.want(rig)
    assert frames.draw(placed(fresh(), WINDOW), WINDOW, Moment())
    assert frames.rig.left == rig.left
    assert frames.rig.prefilter.method == "forward"
    assert frames.is_standing_in
    settle(frames, fresh(rig=rig))
    assert not frames.is_standing_in
    # Its tables serve for another brightness: no stand-in.
    brighter = with_method(rig, "optimal", brightness=0.8)
    frames.want(brighter)
    frames.draw(placed(fresh(), WINDOW), WINDOW, Moment())
    assert not frames.is_standing_in
    assert frames.rig.prefilter.brightness == 0.8
    frames.release()


def test_a_key_held_down_is_followed_frame_by_frame(device: Device) -> None:
    frames = Frames(device, RIG, Known(), rays=RAYS)
    for step in range(5):
        eye = RIG.left.model_copy(update={"sphere_d": -2.0 - step})
        frames.want(with_method(RIG.model_copy(update={"left": eye}), "optimal"))
        frames.draw(placed(fresh(), WINDOW), WINDOW, Moment())
        assert frames.rig.left.sphere_d == -2.0 - step
    frames.release()


def test_what_cannot_be_made_is_said_once_and_the_old_stays(
    device: Device, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_: Any, **__: Any) -> Any:
        raise InputError("panel: found too much, wanted less")
        yield

    frames = Frames(device, RIG, Known(), rays=RAYS)
    monkeypatch.setattr(optimal.TableBuilder, "__init__", optimal.TableBuilder.__init__)
    monkeypatch.setattr("vrlf.renderer.stream.OptimalTables.building", refuse)
    rig = with_method(OTHER, "optimal")
    settle(frames, fresh(rig=rig))
    assert frames.rig.prefilter.method == "forward"
    assert frames.rig.left == OTHER.left
    assert "too much" in str(frames.take_failure())
    assert frames.take_failure() is None
    frames.release()


def test_less_effort_means_fewer_rays(device: Device, renderer: GpuRenderer) -> None:
    frames = Frames(device, RIG, Known(), rays=2 * RAYS)
    frames.ease(Effort(0.5))
    codes = settle(frames, fresh())
    frames.release()
    renderer.device.make_current()
    np.testing.assert_array_equal(codes, renderer.encode(wanted(renderer, "perceived")))


def test_the_difference_two_views_and_the_wall(device: Device, renderer: GpuRenderer) -> None:
    frames = Frames(device, RIG, Known(), rays=RAYS)
    difference = settle(frames, fresh(view="difference"))
    two = settle(frames, fresh(view="compare", divider=0.4))
    wall = settle(frames, fresh(view="wall"))
    tiles = placed(fresh(view="wall"), WINDOW)
    frames.release()
    renderer.device.make_current()
    light = {
        name: wanted(renderer, name).astype(np.float64)
        for name in ("panel", "perceived", "uncorrected", "target")
    }
    plain = placed(fresh(), WINDOW)[0].tile
    expected = show_tile(RIG, plain, light["perceived"], second=light["target"])
    np.testing.assert_array_equal(difference, expected)
    divider = round(0.4 * WINDOW[0])
    expected = show_tile(
        RIG, plain, light["uncorrected"], second=light["perceived"], divider_px=divider
    )
    np.testing.assert_array_equal(two, expected)
    for each in tiles:
        second = light[each.second] if each.second else None
        part = show_tile(RIG, each.tile, light[each.first], second=second)
        x, y, width, height = each.tile.window_px
        found = wall[y : y + height, x : x + width].astype(int)
        assert np.abs(found - part).max() <= 1  # means over areas round
    covered = sum(each.tile.window_px[2] * each.tile.window_px[3] for each in tiles)
    assert (wall == BACKGROUND_CODE).all(axis=2).sum() >= WINDOW[0] * WINDOW[1] - covered


def test_fading_ends_in_grey_without_a_new_frame(device: Device) -> None:
    frames = Frames(device, RIG, Known(), rays=RAYS)
    settle(frames, fresh())
    frames.put(placed(fresh(), WINDOW), WINDOW, fade=1.0)
    assert (frames.canvas.read()[..., :3] == GREY_CODE).all()
    frames.release()


def test_another_panel_and_another_window(device: Device, renderer: GpuRenderer) -> None:
    small = pass_rigs.SMALL["bgr-walls"]
    frames = Frames(device, RIG, Known(), rays=RAYS)
    settle(frames, fresh())
    size = (small.panel.width_px, small.panel.height_px)
    frames.want(small)
    session = fresh(rig=small)
    while frames.draw(placed(session, size), size, Moment()):
        pass
    codes = frames.canvas.read()[::-1, :, :3]
    frames.release()
    renderer.device.make_current()
    np.testing.assert_array_equal(codes, renderer.encode(wanted(renderer, "perceived", small)))


def test_the_loupe_shows_the_pixel_under_the_cursor() -> None:
    size = (800, 600)
    session = fresh(view="compare", divider=0.5)
    under = tile_under(placed(session, size), (650.0, 300.0))
    assert under is not None
    found = loupe(under, (650.0, 300.0), size)
    assert isinstance(found, Placed)
    assert found.first == under.second
    assert found.tile.pixel_of((650.0, 300.0)) == under.tile.pixel_of((650.0, 300.0))
    corner = loupe(under, (799.0, 1.0), size)
    if corner is not None:
        x, y, width, height = corner.tile.window_px
        assert 0 <= x <= 800 - width
        assert 0 <= y <= 600 - height
    assert placed(session, (0, 0)) == ()


def test_alignment_screens_take_the_panels_place_or_the_targets(device: Device) -> None:
    live = Known()
    frames = Frames(device, RIG, live, rays=RAYS)
    plain = settle(frames, fresh(view="panel"))
    fringes = settle(frames, fresh(view="panel"), Moment(screen="fringes up"))
    # The waves are 32-bit numbers on the GPU: a code may be the next one.
    wanted_codes = encode(twin.fringes(RIG, 1)).astype(int)
    assert np.abs(fringes.astype(int) - wanted_codes).max() <= 1
    seen = settle(frames, fresh(), Moment(screen="fringes up"))
    lines = settle(frames, fresh(view="target"), Moment(screen="separation"))
    np.testing.assert_array_equal(lines, encode(twin.separation_screen(RIG)))
    np.testing.assert_array_equal(settle(frames, fresh(view="panel")), plain)
    assert (seen[..., 1] > 0).any()
    assert not seen[..., 0].any()
    assert live.drawn == 2, "once at first, once after the lines"
    frames.release()


def test_the_window_says_how_near_the_perceived_picture_comes(device: Device) -> None:
    rig = cropped(load_rig("two-eyes"), (280, 150))
    frames = Frames(device, rig, Known(), rays=RAYS)
    settle(frames, replace(Session(rig=rig, loaded=rig), view="target"))
    assert frames.likening.words == ""
    settle(frames, Session(rig=rig, loaded=rig))
    target, seen = (
        np.asarray(each.read()[..., :3]) for each in (frames.stream.target, frames.stream.seen)
    )
    for side in SIDES:
        found, alike = frames.likening.found[side], likeness(seen, target, rig, side)
        assert found.psnr_db == pytest.approx(alike.psnr_db, abs=0.01)
        assert f"{side} {alike.psnr_db:.1f} dB" in frames.likening.words
    before = dict(frames.likening.found)
    dimmer = with_method(rig, "none")
    settle(frames, Session(rig=dimmer, loaded=dimmer))
    assert frames.likening.found != before
    settle(frames, Session(rig=dimmer, loaded=dimmer), Moment(screen="fringes up"))
    assert frames.likening.words == "", "an alignment screen is not meant to be the target"
    frames.release()
