"""Perception ray by ray on the GPU against its float64 twin."""

from __future__ import annotations

from typing import Any

import numpy as np
import pass_rigs
import pytest
from numpy.typing import NDArray

from vrlf.errors import InputError
from vrlf.gpu import Device, Texture
from vrlf.model import Rig
from vrlf.optics.tracing import Tracing
from vrlf.passes import PerceiveTraced, TracedTables, traced_tables
from vrlf.passes import traced as traced_pass
from vrlf.reference.quadrature import perceive_well
from vrlf.reference.traced import perceive_traced

Light = NDArray[Any]

RAYS = 24
# Both sides trace the same rays; a 32-bit landing is good to 1e-4 um where the map of
# diffraction is smooth. A ray within 0.05 um of an edge may fall on its other side.
SAME_LIGHT = 1e-4
EDGE_SHARE = 2e-3
BOTH = Tracing(diffraction=True, exact=True)
DIFFRACTION, EXACT = Tracing(diffraction=True), Tracing(exact=True)
CASES = {
    "chromatic-one": ("one-chromatic-eye", BOTH),
    "walls": ("bgr-walls", BOTH),
    "walls-turned": ("rgb-walls-turned", DIFFRACTION),
    "leaning-walls-acrylic": ("full-leaning-walls", BOTH),
    "coma": ("coma-lenslets", EXACT),
    "eighth-order": ("coma-lenslets", DIFFRACTION),
    "round-holes": ("round-holes-moved", DIFFRACTION),
    "square-holes": ("square-holes-walls", DIFFRACTION),
    "diamonds": ("diamonds-lenslets", BOTH),
    "diamonds-holes": ("diamonds-holes", DIFFRACTION),
    "rgbg": ("rgbg-walls", EXACT),
    "dispersing": ("dispersing-lenslets-walls", BOTH),
    "dispersing-thin": ("dispersing-lenslets-walls", DIFFRACTION),
}


def perceived(
    device: Device,
    rig: Rig,
    panel: Light,
    tracing: Tracing,
    exposure: float = 1.0,
    rays: int = RAYS,
) -> Light:
    """What the pass makes of a panel image, (H, W, 3)."""
    owned: list[Any] = [PerceiveTraced(device)]
    try:
        owned.append(tables := TracedTables(device, rig, rays, tracing))
        owned.append(shown := Texture.from_array(device, panel, label="panel"))
        owned.append(seen := Texture(device, shown.size_px, label="seen"))
        owned[0].run(tables, shown, seen, exposure=exposure)
        return seen.read()[..., :3]
    finally:
        for each in owned:
            each.release()


@pytest.mark.parametrize("name", CASES)
def test_traced_perception_matches_its_twin(device: Device, name: str) -> None:
    small, tracing = CASES[name]
    rig, panel = pass_rigs.case(small)
    error = perceived(device, rig, panel, tracing) - perceive_traced(panel, rig, RAYS, tracing)
    off = np.abs(error).max(axis=-1)
    print(f"{name}: {(off > SAME_LIGHT).sum()} of {off.size} apart, greatest {off.max():.1e}")
    assert (off > SAME_LIGHT).mean() <= EDGE_SHARE
    # Two rays' light, at most at four times the radiance (a diamond's red).
    assert off.max() <= 2 * 4 / RAYS


def test_without_options_it_is_the_fast_passs_integral(device: Device) -> None:
    for name in ("rgbg-bare", "diamonds-lenslets", "square-holes-walls"):
        rig, panel = pass_rigs.case(name)
        plain = perceived(device, rig, panel, Tracing(), rays=4096)
        error = float(np.sqrt(np.mean((plain - perceive_well(panel, rig, 1024)) ** 2)))
        print(f"{name}: {error:.1e} RMS")
        # Points by chance on noise: light that fills a quarter of the pixels at four times the
        # radiance has a variance of 4/3, over 4096 rays 0.018; well-spread ones do better.
        assert error <= 0.018


def test_no_light_is_lost_however_many_points(device: Device) -> None:
    # A white panel beyond which next to nothing is spread; more points than one batch holds.
    rig = pass_rigs.rig(
        32,
        20,
        panel={"subpixels": "full", "pixel_pitch_um": 200.0},
        headset={"lens_separation_mm": 3.2},
        array=pass_rigs.HOLES | {"aperture_um": 75.0},
        left={"sphere_d": 0.0, "pupil_mm": 3.0},
        right={"sphere_d": 0.0, "pupil_mm": 3.0},
    )
    white = np.ones((20, 32, 3), np.float32)
    spread = perceived(device, rig, white, DIFFRACTION, rays=600)
    plain = perceived(device, rig, white, Tracing(), rays=600)
    # 600 / 3.7 % is 16,000 points, three batches. The middle is 1.4 mm from the borders, some 30
    # widths lambda g / w of 44 um: 2 / (pi^2 30) of the light goes farther along each axis.
    middle = np.s_[8:12, 6:10]
    lost = 1.0 - spread[middle].mean() / plain[middle].mean()
    print(f"beyond 1.4 mm: {lost:.4f} of the light")
    assert 0.0 < lost < 2.0 / (np.pi**2 * 30.0) * 2.0
    assert plain[middle].mean() == pytest.approx((75.0 / 390.0) ** 2, rel=0.1)


@pytest.mark.parametrize("limit", ["_BATCH_POINTS", "_DISPATCH_RAYS"])
def test_cut_up_work_gives_the_same_image(
    device: Device, monkeypatch: pytest.MonkeyPatch, limit: str
) -> None:
    rig, panel = pass_rigs.case("diamonds-holes")
    whole = perceived(device, rig, panel, DIFFRACTION)
    assert perceived(device, rig, panel, DIFFRACTION).tobytes() == whole.tobytes()
    module = traced_tables if limit == "_BATCH_POINTS" else traced_pass
    monkeypatch.setattr(module, limit, {"_BATCH_POINTS": 50, "_DISPATCH_RAYS": 20_000}[limit])
    cut = perceived(device, rig, panel, DIFFRACTION)
    # Rounding of sums in another order.
    assert np.abs(cut - whole).max() <= 1e-6


def test_exposure_scales_what_is_seen(device: Device) -> None:
    rig, panel = pass_rigs.case("chromatic")
    once, thrice = (perceived(device, rig, panel, Tracing(), exposure=e) for e in (1.0, 3.0))
    assert thrice == pytest.approx(3.0 * once, rel=1e-6)


def test_each_colour_is_spread_by_its_own_wavelength(device: Device) -> None:
    def seen(*wavelengths_nm: float) -> Light:
        rig = pass_rigs.rig(
            40,
            26,
            panel={"subpixels": "full", "wavelengths_nm": wavelengths_nm},
            array=pass_rigs.HOLES | {"aperture_um": 60.0},
        )
        return perceived(device, rig, pass_rigs.picture(rig), DIFFRACTION)

    whole = seen(700.0, 550.0, 400.0)
    for colour, nm in enumerate((700.0, 550.0, 400.0)):
        assert np.array_equal(whole[..., colour], seen(nm, nm, nm)[..., colour])
        assert not np.array_equal(whole[..., colour], seen(610.0, 610.0, 610.0)[..., colour])


@pytest.mark.parametrize(
    ("rig", "tracing", "said"),
    [
        (pass_rigs.SMALL["glass-lenslets-walls"], DIFFRACTION, "headset.glass: found "),
        (pass_rigs.HEXAGONAL["hexagonal-lenslets"], EXACT, 'array.lattice: found "hexagonal"'),
        (
            pass_rigs.VARYING["varying-lenslets"],
            EXACT,
            "array.pitch_growth_per_cm2: found [0.3, -0.08], wanted [0, 0] for rays traced one by",
        ),
        (
            pass_rigs.VARYING["varying-square-holes"],
            DIFFRACTION,
            "array.pitch_growth_per_cm2: found [0.3, -0.08], wanted [0, 0] for rays traced one by",
        ),
        (
            pass_rigs.rig(
                40,
                20,
                array=pass_rigs.LENSLETS
                | {
                    "focal_mm": 0.0,
                    "lenslet": {
                        "radii_mm": [1.0, -1.0],
                        "thicknesses_mm": [0.2],
                        "glasses": ["1.5/55"],
                    },
                },
            ),
            EXACT,
            "exact: found an array.lenslet of several surfaces",
        ),
    ],
)
def test_what_it_does_not_know_is_refused_in_one_line(
    device: Device, rig: Rig, tracing: Tracing, said: str
) -> None:
    panel = pass_rigs.picture(rig)
    for refuse in (
        lambda: perceived(device, rig, panel, tracing),
        lambda: perceive_traced(panel, rig, RAYS, tracing),
    ):
        with pytest.raises(InputError) as error:
            refuse()
        assert said in str(error.value)
        assert "\n" not in str(error.value)
