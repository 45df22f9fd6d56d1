"""The Python interface as a user meets it: types, errors, and what the eyes see."""

from __future__ import annotations

import doctest
import json
import subprocess
import sys
from collections.abc import Iterator
from functools import partial
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import vrlf
import vrlf.api
from vrlf.errors import InputError, RigError
from vrlf.gpu import Device
from vrlf.model import Rig
from vrlf.renderer import ReferenceRenderer

Light = NDArray[Any]

SMALL = ["panel.width_px=60", "panel.height_px=30", "headset.lens_separation_mm=2.34"]
RAYS = 16


def small(name: str = "matched-microlens", *changes: str, **eyes: str) -> Rig:
    """A shipped rig on a panel of 60 x 30 pixels."""
    return vrlf.load_rig(name, overrides=[*SMALL, *changes], **eyes)


def picture(seed: int = 5) -> Light:
    """Random light for ``small``."""
    return np.random.default_rng(seed).random((30, 60, 3), dtype=np.float32)


@pytest.fixture
def renderer(device: Device) -> Iterator[vrlf.Renderer]:
    """One GPU context for a test's calls."""
    with vrlf.Renderer(device) as made:
        yield made


def test_all_names_are_there() -> None:
    for name in vrlf.__all__:
        assert getattr(vrlf, name) is not None
        assert name in dir(vrlf)
    assert set(vrlf.api.__all__) | {"__version__"} == set(vrlf.__all__)
    with pytest.raises(AttributeError, match="prefilters"):
        vrlf.prefilters  # noqa: B018


def test_the_modules_own_example_is_true() -> None:
    """All but the number of rays, which is fewer: a whole panel takes the CPU some seconds."""
    text = vrlf.api.__doc__
    assert text is not None
    few = SimpleNamespace(**{name: getattr(vrlf, name) for name in vrlf.__all__})
    few.perceive = partial(vrlf.perceive, rays=4)
    example = doctest.DocTestParser().get_doctest(text, {}, "vrlf.api", None, None)
    assert len(example.examples) >= 6
    # The example imports vrlf itself; what it then calls is the one with few rays.
    first = example.examples[0]
    assert first.source == "import numpy as np, vrlf\n"
    example.globs.update(np=np, vrlf=few)
    example.examples = example.examples[1:]
    said: list[str] = []
    runner = doctest.DocTestRunner(optionflags=doctest.ELLIPSIS)
    assert runner.run(example, out=said.append, clear_globs=False).failed == 0, "".join(said)
    wanted = (few.load_rig("matched-microlens").panel.height_px, 1334, 3)
    for name in ("panel", "seen"):
        result = example.globs[name]
        assert result.shape == wanted
        assert result.dtype == np.float32


# --- types ------------------------------------------------------------------------------------


@pytest.mark.parametrize("step", ["prefilter", "perceive"])
def test_results_are_float32_on_the_panels_raster(renderer: vrlf.Renderer, step: str) -> None:
    rig, call = small(), getattr(vrlf, step)
    given = picture()
    wanted = call(given, rig, renderer=renderer)
    assert isinstance(wanted, np.ndarray)
    assert wanted.dtype == np.float32
    assert wanted.shape == given.shape
    assert wanted.flags.writeable
    assert wanted.flags.c_contiguous
    # The same numbers in any container of theirs.
    others = [
        given.astype(np.float64),
        given.tolist(),
        np.asfortranarray(given),
        given[::-1].copy()[::-1],
        np.pad(given, ((0, 0), (0, 0), (0, 1)))[..., :3],
    ]
    for other in others:
        assert np.array_equal(call(other, rig, renderer=renderer), wanted)


@pytest.mark.parametrize("dtype", [np.uint8, np.int64, bool, np.float16])
def test_other_numbers_are_taken_at_their_value(renderer: vrlf.Renderer, dtype: Any) -> None:
    whole = (picture() > 0.5).astype(dtype)
    wanted = vrlf.prefilter(whole.astype(np.float32), small(), renderer=renderer)
    assert np.array_equal(vrlf.prefilter(whole, small(), renderer=renderer), wanted)


# --- without a renderer, without a GPU --------------------------------------------------------


def test_without_a_renderer_the_result_is_the_same(renderer: vrlf.Renderer) -> None:
    # Holes, so that an exposure that got lost would show.
    rig, target = small("pinhole"), picture()
    panel = vrlf.prefilter(target, rig)
    assert np.array_equal(panel, vrlf.prefilter(target, rig, renderer=renderer))
    seen = vrlf.perceive(panel, rig, rays=RAYS, exposure="none")
    kept = vrlf.perceive(panel, rig, rays=RAYS, exposure="none", renderer=renderer)
    assert np.array_equal(seen, kept)


def test_results_are_the_renderers(renderer: vrlf.Renderer) -> None:
    rig, target = small("pinhole"), picture()
    assert np.array_equal(
        vrlf.prefilter(target, rig, renderer=renderer), renderer.prefilter(target, rig)
    )
    seen = vrlf.perceive(target, rig, rays=RAYS, exposure="none", renderer=renderer)
    assert np.array_equal(seen, renderer.perceive(target, rig, rays=RAYS, exposure="none"))
    # The defaults, said once more: 256 rays and the array's light made up for.
    seen = vrlf.perceive(target, rig, renderer=renderer)
    assert np.array_equal(seen, renderer.perceive(target, rig, rays=256, exposure="auto"))


def test_a_call_of_its_own_gives_its_context_back(monkeypatch: pytest.MonkeyPatch) -> None:
    made: list[Device] = []
    headless = Device.headless

    def noted() -> Device:
        made.append(headless())
        return made[-1]

    monkeypatch.setattr(Device, "headless", noted)
    vrlf.perceive(picture(), small(), rays=1)
    with pytest.raises(InputError):
        vrlf.perceive(picture(), small(), rays=0)
    assert len(made) == 2
    for device in made:
        assert device.live_objects == ()
        with pytest.raises(Exception, match="released"):
            device.check("anything")


def test_bad_input_is_refused_before_a_context_is_made(monkeypatch: pytest.MonkeyPatch) -> None:
    def never() -> Device:
        raise AssertionError("a GPU context for an input that cannot be used")

    monkeypatch.setattr(Device, "headless", never)
    with pytest.raises(InputError, match="target: found 3x3"):
        vrlf.prefilter(np.zeros((3, 3)), small())
    with pytest.raises(InputError, match="panel image: found 1 value"):
        vrlf.perceive(np.where(np.arange(5400).reshape(30, 60, 3) == 7, np.nan, 0.0), small())


# What a fresh interpreter runs: a GPU library that must not be called.
_NO_GPU = """
import json, sys
import vrlf
assert "moderngl" not in sys.modules, "import vrlf touches a GPU library"
import moderngl
def refused(*_, **__):
    raise AssertionError("a GPU context for numbers alone")
moderngl.create_context = moderngl.create_standalone_context = refused
print(json.dumps(vrlf.inspect(vrlf.load_rig("two-eyes")), allow_nan=False))
"""


def test_inspecting_needs_no_gpu() -> None:
    done = subprocess.run(
        [sys.executable, "-c", _NO_GPU], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert found == vrlf.inspect(vrlf.load_rig("two-eyes"))
    assert found["left"]["axis_deg"] == pytest.approx(30.0)
    assert set(found) >= {"left", "right", "array", "display", "warnings"}


# --- errors -----------------------------------------------------------------------------------


@pytest.mark.parametrize("step", ["prefilter", "perceive"])
def test_errors_are_one_line(renderer: vrlf.Renderer, step: str) -> None:
    call = partial(getattr(vrlf, step), rig=small(), renderer=renderer)
    for bad in (picture()[:, :50], picture()[..., 0], np.full((30, 60, 3), np.inf), "x", [[]]):
        with pytest.raises(InputError) as caught:
            call(bad)
        assert "\n" not in str(caught.value)
        assert "wanted" in str(caught.value)
    # The renderer is none the worse for it.
    assert call(picture()).shape == (30, 60, 3)


def test_rigs_that_are_none() -> None:
    with pytest.raises(InputError, match="matched-mikrolens"):
        vrlf.load_rig("matched-mikrolens")
    with pytest.raises(RigError) as caught:
        vrlf.load_rig("bare", overrides=["left.pupil_mm=-1", "panel.colour=3"], right="-5 / x")
    text = str(caught.value)
    assert "\n" not in text
    assert "--right" in text


# --- what is seen -----------------------------------------------------------------------------


def test_a_perfect_eye_sees_what_a_bare_panel_shows(renderer: vrlf.Renderer) -> None:
    """On the headset's striped panel, and whatever the number of rays."""
    panel = picture()
    for rays in (1, RAYS):
        seen = vrlf.perceive(panel, small("bare", both="plano"), rays=rays, renderer=renderer)
        # The mean of float32 areas.
        assert seen == pytest.approx(panel, abs=2e-6)


def test_a_bare_panel_shows_the_target(renderer: vrlf.Renderer) -> None:
    target = picture()
    assert np.array_equal(vrlf.prefilter(target, small("bare"), renderer=renderer), target)


def test_two_different_eyes_see_differently(renderer: vrlf.Renderer) -> None:
    """One picture for both halves: what differs is the eyes' own, and each has its own half."""
    half = picture()[:, :30]
    target = np.concatenate([half, half], axis=1)
    alike = small("bare", both="-3.00")
    apart = small("bare", left="-3.00", right="+1.00 / -2.00 x 30")
    swapped = small("bare", left="+1.00 / -2.00 x 30", right="-3.00")

    def eyes(rig: Rig) -> tuple[Light, Light]:
        seen = vrlf.perceive(target, rig, rays=RAYS, renderer=renderer)
        return seen[:, :30], seen[:, 30:]

    same, each, other = eyes(alike), eyes(apart), eyes(swapped)
    assert np.array_equal(same[0], same[1])
    assert np.array_equal(each[0], same[0])
    assert np.abs(each[0] - each[1]).max() > 0.1
    assert np.array_equal(each[0], other[1])
    assert np.array_equal(each[1], other[0])


def test_each_eye_is_shown_its_own_panel_image(renderer: vrlf.Renderer) -> None:
    rig = small(both="-5.00")
    changed = small(left="-5.00", right="-2.00")
    target = picture()
    both, one = (vrlf.prefilter(target, each, renderer=renderer) for each in (rig, changed))
    assert np.array_equal(both[:, :30], one[:, :30])
    assert np.abs(both[:, 30:] - one[:, 30:]).max() > 0.1


def test_same_bytes_twice(renderer: vrlf.Renderer) -> None:
    rig, target = small("two-eyes"), picture()

    def chain(**with_renderer: Any) -> bytes:
        panel = vrlf.prefilter(target, rig, **with_renderer)
        return bytes(vrlf.perceive(panel, rig, rays=RAYS, **with_renderer).tobytes())

    assert chain(renderer=renderer) == chain(renderer=renderer) == chain()


def test_the_whole_interface_is_the_references(renderer: vrlf.Renderer) -> None:
    rig, target, reference = small("two-eyes"), picture(), ReferenceRenderer()
    panel = vrlf.prefilter(target, rig, renderer=renderer)
    seen = vrlf.perceive(panel, rig, rays=RAYS, renderer=renderer)
    for got, wanted in (
        (panel, reference.prefilter(target, rig)),
        (seen, reference.perceive(panel, rig, rays=RAYS)),
    ):
        # A ray on an edge may fall on its other side: 2 of 1800 pixels at most.
        assert np.count_nonzero(np.abs(got - wanted).max(axis=-1) > 1e-4) <= 2


def test_rigs_serve_as_they_are_typed(renderer: vrlf.Renderer) -> None:
    """Left, right and both are prescriptions as written on paper; overrides win over them."""
    rig = small("bare", "left.sphere_d=-1.5", both="-5.00 / -1.25 x 170", right="-4.50")
    assert (rig.left.sphere_d, rig.left.cylinder_d, rig.left.axis_deg) == (-1.5, -1.25, 170.0)
    assert (rig.right.sphere_d, rig.right.cylinder_d) == (-4.5, 0.0)
    assert vrlf.perceive(picture(), rig, rays=1, renderer=renderer).shape == (30, 60, 3)
