"""A ray tracer of its own: what the equations say, with nothing of vrlf's optics in it.

Written from the published equations alone (rays of two thin lenses, Thibos's power vectors,
OSA/ANSI Z80.28 polynomials), so that a slip in vrlf's optics, which the GPU passes and their
float64 twins share, shows as a difference here. Plain and slow: every ray is traced by
itself, the aberration is differentiated numerically, the prescription is turned by
trigonometry. The rig's model, which only holds what the user typed, is all that it imports.

Frames: x right, y up as the wearer sees it; the examiner's x axis runs the other way.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import cos, factorial, pi, radians, sin, sqrt
from typing import Any

import numpy as np

from vrlf.model import Eye, Rig

Points = np.ndarray[Any, np.dtype[np.float64]]

_RAYS_AT_ONCE = 64


@dataclass(frozen=True)
class Setup:
    """One eye before the headset; lengths in mm."""

    rig: Rig
    eye: Eye
    columns: range
    axis: Points  # of the lens, in the panel frame
    lens: float  # F, 1/mm, of the colour at hand
    lens_589: float  # at the wavelength of prescriptions
    relief: float  # e
    to_array: float  # s_a
    gap: float  # g, reduced

    @property
    def reach(self) -> float:
        """Height on the array of the chief ray per height on the panel, times m."""
        return self.relief + self.to_array * (1 - self.relief * self.lens)

    @property
    def m(self) -> float:
        """Panel height of a unit slope."""
        return self.reach + self.gap * (1 - self.relief * self.lens)

    @property
    def at_589(self) -> Setup:
        """The same at the wavelength that names the retinal image, and that walls are built for."""
        return replace(self, lens=self.lens_589)

    def of(self, colour: int) -> Setup:
        """The same for one of the panel's colours."""
        glass = self.rig.headset.glass
        if glass is None:
            return self
        um = self.rig.panel.wavelengths_nm[colour] / 1000
        return replace(
            self, lens=self.lens_589 * (index(glass, um) - 1) / (index(glass, 0.589) - 1)
        )


def index(glass: str, um: float) -> float:
    """Published formulas: Sultanova 2009 (fit), Beadie 2015, Schott's catalogue."""
    if glass == "polycarbonate":
        return sqrt(1 + 1.4182 / (1 - 0.021304 / um**2))
    if glass == "pmma":
        even = 2.1778 + 6.1209e-3 * um**2 - 1.5004e-3 * um**4
        odd = 2.3678e-2 / um**2 - 4.2137e-3 / um**4 + 7.3417e-4 / um**6 - 4.5042e-5 / um**8
        return sqrt(even + odd)
    assert glass == "n-bk7"
    pairs = (1.03961212, 0.00600069867), (0.231792344, 0.0200179144), (1.01046945, 103.560653)
    return sqrt(1 + sum(b * um**2 / (um**2 - c) for b, c in pairs))


def setups(rig: Rig) -> tuple[Setup, Setup]:
    """The left and the right eye's."""
    headset, array, width = rig.headset, rig.array, rig.panel.width_px
    power = headset.lens_power_d
    lens = 1 / headset.lens_to_panel_mm if power is None else power / 1000
    gap, to_array = 0.0, headset.lens_to_panel_mm
    if array.kind != "none":
        gap, to_array = array.gap_mm / array.gap_index, headset.lens_to_panel_mm - array.gap_mm
    e = headset.eye_relief_mm
    half = headset.lens_separation_mm / 2

    def one(eye: Eye, columns: range, side: int) -> Setup:
        axis = np.array([side * half, headset.lens_height_mm])
        return Setup(rig, eye, columns, axis, lens, lens, e, to_array, gap)

    right = range(width - width // 2, width)
    return one(rig.left, range(width // 2), -1), one(rig.right, right, 1)


def zernike(n: int, m: int, x: Points, y: Points) -> Points:
    """Normalised OSA/ANSI polynomial of the unit pupil."""
    radius, angle, order = np.hypot(x, y), np.arctan2(y, x), abs(m)
    radial = sum(
        (-1) ** k
        * factorial(n - k)
        / (factorial(k) * factorial((n + order) // 2 - k) * factorial((n - order) // 2 - k))
        * radius ** (n - 2 * k)
        for k in range((n - order) // 2 + 1)
    )
    norm = sqrt((n + 1) * (1 if m == 0 else 2))
    return norm * radial * (np.cos(order * angle) if m >= 0 else np.sin(order * angle))


def wavefront_um(eye: Eye, u: Points) -> Points:
    """The measured wavefront over the pupil, seen from the wearer's side."""
    total = np.zeros(u.shape[:-1])
    if eye.zernike is not None:
        radius = eye.zernike.diameter_mm / 2
        for name, um in eye.zernike.coefficients_um.items():
            n, m = (int(part) for part in name.split(","))
            total += um * zernike(n, m, -u[..., 0] / radius, u[..., 1] / radius)
    return total


def sphere_along(eye: Eye) -> tuple[float, float]:
    """Powers in dioptres at the pupil: along the cylinder's axis and across it."""
    powers = eye.sphere_d, eye.sphere_d + eye.cylinder_d
    v = eye.vertex_mm / 1000
    return powers[0] / (1 - v * powers[0]), powers[1] / (1 - v * powers[1])


def accommodation_d(setup: Setup) -> float:
    """What the eye adds to see the panel's mean image sharply, within its age's means."""
    eye = setup.eye
    if eye.accommodation == "relaxed":
        return 0.0
    d = setup.to_array + setup.gap
    error = sum(sphere_along(eye)) / 2 + 1000 * (1 - d * setup.lens_589) / setup.at_589.m
    if eye.zernike is not None:
        c20 = eye.zernike.coefficients_um.get("2,0", 0.0)
        error += -4 * sqrt(3) * c20 / (eye.zernike.diameter_mm / 2) ** 2
    age = 30.0 if eye.age_years is None else eye.age_years
    return min(max(error, 0.0), max(0.0, 18.5 - 0.30 * age))


def aberration(setup: Setup, colour: int, u: Points) -> Points:
    """T at the pupil points ``u`` (..., 2), measured from the axis: slopes right and up."""
    eye = setup.eye
    v = u - np.array(eye.pupil_offset_mm)
    # The axis as the wearer sees it: the examiner's angle, mirrored.
    angle = pi - radians(eye.axis_deg)
    along, across = np.array([cos(angle), sin(angle)]), np.array([-sin(angle), cos(angle)])
    on_axis_d, off_axis_d = sphere_along(eye)
    common_d = -accommodation_d(setup)
    if eye.chromatic:

        def focus(um: float) -> float:
            return 1.7312 - 0.63346 / (um - 0.21410)

        common_d += focus(setup.rig.panel.wavelengths_nm[colour] / 1000) - focus(0.589)
    slopes = (on_axis_d + common_d) * (v @ along)[..., None] * along
    slopes = slopes + (off_axis_d + common_d) * (v @ across)[..., None] * across
    step = 1e-4  # mm; the difference is then exact to 1e-8 of a dioptre's slope
    for direction in (0, 1):
        move = np.eye(2)[direction] * step
        rise_um = wavefront_um(eye, v + move) - wavefront_um(eye, v - move)
        slopes[..., direction] -= rise_um / (2 * step)
    return slopes / 1000 + np.array(eye.prism_pd) / 100


def to_lattice(setup: Setup, point: Points) -> Points:
    """A point relative to the axis, in pitches along the lattice's own upright axes."""
    array = setup.rig.array
    p = point + setup.axis - np.array(array.offset_um) / 1000
    c, s = cos(radians(array.rotation_deg)), sin(radians(array.rotation_deg))
    turned = np.stack([c * p[..., 0] + s * p[..., 1], c * p[..., 1] - s * p[..., 0]], axis=-1)
    return turned / (array.pitch_um / 1000)


def from_lattice(setup: Setup, cells: Points) -> Points:
    """The reverse."""
    array = setup.rig.array
    q = cells * (array.pitch_um / 1000)
    c, s = cos(radians(array.rotation_deg)), sin(radians(array.rotation_deg))
    turned = np.stack([c * q[..., 0] - s * q[..., 1], s * q[..., 0] + c * q[..., 1]], axis=-1)
    return turned + np.array(array.offset_um) / 1000 - setup.axis


def nearest_centre(setup: Setup, place: Points) -> Points:
    """The centre nearest to a place of the lattice, in pitches.

    A hexagonal lattice is two rectangular ones, 1 by root 3, one in the other's middle.
    """
    array = setup.rig.array
    if any(array.pitch_growth_per_cm2):
        centres = [
            columns_centre(place[..., i], growth * (array.pitch_um / 1e4) ** 2)
            for i, growth in enumerate(array.pitch_growth_per_cm2)
        ]
        return np.stack(centres, axis=-1)
    if array.lattice == "square":
        return np.asarray(np.rint(place))
    sides = np.array([1.0, sqrt(3)])
    first = np.rint(place / sides) * sides
    second = (np.rint(place / sides - 0.5) + 0.5) * sides
    apart = [np.hypot(*np.moveaxis(place - each, -1, 0))[..., None] for each in (first, second)]
    return np.where(apart[0] <= apart[1], first, second)


def columns_centre(place: Points, growth: float) -> Points:
    """Of columns that stand at k (1 + growth k^2 / 3): the one whose borders enclose a place."""
    k = np.arange(-1000, 1001)
    standing = k * (1 + growth * k**2 / 3)
    borders = (k - 0.5) * (1 + growth * (k - 0.5) ** 2 / 3)
    # As far as they do not turn back.
    rising = 1 + growth * k**2 > 0.1
    return np.asarray(standing[rising][np.searchsorted(borders[rising], place) - 1])


def passes_walls(setup: Setup, cell: Points, x: Points) -> Any:
    """Whether the panel point belongs to the cell with this centre."""
    barriers = setup.rig.array.barriers
    if barriers == "none":
        return np.ones(x.shape[:-1], bool)
    seen_at = x if barriers == "perpendicular" else x * setup.at_589.reach / setup.at_589.m
    owner = nearest_centre(setup, to_lattice(setup, seen_at))
    return (np.abs(owner - cell) < 0.1).all(axis=-1)


def trace(setup: Setup, colour: int, X: Points, u: Points) -> tuple[Points, Any]:
    """Where the backward rays meet the panel, relative to the axis, and which get there."""
    rig, array = setup.rig, setup.rig.array
    alpha = X / setup.at_589.m + aberration(setup, colour, u)
    h = u + setup.relief * alpha
    beta = alpha - setup.lens * h
    y = h + setup.to_array * beta
    if array.kind == "none":
        return y, np.ones(y.shape[:-1], bool)
    place = to_lattice(setup, y)
    cell = nearest_centre(setup, place)
    if array.kind == "microlens":
        x = y + setup.gap * (beta - (y - from_lattice(setup, cell)) / focal_mm(rig, colour))
        return x, passes_walls(setup, cell, x)
    x = y + setup.gap * beta
    off = np.abs(place - cell) * array.pitch_um
    wide = np.hypot(off[..., 0], off[..., 1]) if array.aperture_shape == "circle" else off.max(-1)
    return x, (wide <= array.aperture_um / 2) & passes_walls(setup, cell, x)


def emitter(name: str, colour: int, i: Any, j: Any) -> tuple[Any, Any, Any, Any, float]:
    """Left, top, right, bottom in pixel (i, j) and radiance; right is left where there is none."""
    if name == "full":
        return 0.0, 0.0, 1.0, 1.0, 1.0
    if name in ("rgb-stripe", "bgr-stripe"):
        place = colour if name == "rgb-stripe" else 2 - colour
        return place / 3, 0.0, (place + 1) / 3, 1.0, 3.0
    low, high = {
        "pentile-rgbg": (((0.06, 0.06), (0.66, 0.06)), ((0.54, 0.94), (0.94, 0.94))),
        "pentile-diamond": (((0.07, 0.07), (0.62, 0.62)), ((0.53, 0.53), (0.98, 0.98))),
    }[name]
    if colour == 1:
        (left, top), (right, bottom) = low[1], high[1]
        return left, top, right, bottom, 1 / ((right - left) * (bottom - top))
    (left, top), (right, bottom) = low[0], high[0]
    if colour == 2 and name == "pentile-diamond":
        left, top, right, bottom = 0.02, 0.02, 0.58, 0.58
    # Red stands on the dark squares of a chess board, blue on the others.
    has = (i + j) % 2 == colour // 2
    return left, top, np.where(has, right, left), bottom, 2 / ((right - left) * (bottom - top))


def focal_mm(rig: Rig, colour: int) -> float:
    """As given, or r / (n - 1) of a plano-convex lenslet, n = A + B / lambda^2 (Cauchy)."""
    lenslet = rig.array.lenslet
    if lenslet is None:
        return rig.array.focal_mm
    n_d, abbe = (float(part) for part in lenslet.glass.split("/"))  # type: ignore[union-attr]
    um = rig.panel.wavelengths_nm[colour] / 1000
    b = (n_d - 1) / abbe / (1 / 0.48613**2 - 1 / 0.65628**2)
    return lenslet.radius_mm / (n_d + b * (1 / um**2 - 1 / 0.58756**2) - 1)  # type: ignore[operator]


def emitted(setup: Setup, panel: Points, colour: int, x: Points) -> Points:
    """Light that the panel sends out at the points, of its own half only."""
    given = setup.rig.panel
    pitch = given.pixel_pitch_um / 1000
    across = (x[..., 0] + setup.axis[0]) / pitch + given.width_px / 2
    down = given.height_px / 2 - (x[..., 1] + setup.axis[1]) / pitch
    i, j = np.floor(across).astype(int), np.floor(down).astype(int)
    seen = (i >= setup.columns.start) & (i < setup.columns.stop) & (j >= 0) & (j < given.height_px)
    light = np.where(seen, panel[j * seen, i * seen, colour], 0.0)
    left, top, right, bottom, gain = emitter(given.subpixels, colour, i, j)
    within = (across - i >= left) & (across - i < right) & (down - j >= top) & (down - j < bottom)
    return np.where(within, gain * light, 0.0)


def _halton(count: int, base: int) -> Points:
    values, digits, scale = np.zeros(count), np.arange(count), 1.0
    while digits.any():
        scale /= base
        values += scale * (digits % base)
        digits //= base
    return values


def pixel_centres(setup: Setup) -> Points:
    """(H, columns, 2): the pixels of the eye's half, relative to the axis, in mm."""
    given = setup.rig.panel
    x = (np.array(setup.columns) + 0.5 - given.width_px / 2) * given.pixel_pitch_um / 1000
    y = (given.height_px / 2 - np.arange(given.height_px) - 0.5) * given.pixel_pitch_um / 1000
    return np.stack(np.broadcast_arrays(x[None, :], y[:, None]), axis=-1) - setup.axis


def perceived(panel: Points, rig: Rig, rays: int, seed: int) -> Points:
    """What both eyes see, not divided by the throughput.

    Every pixel takes the same Halton points of pixel and pupil (bases 2, 3, 5, 7), shifted
    round by a random vector of its own.
    """
    random = np.random.default_rng(seed)
    out = np.zeros(panel.shape)
    points = np.stack([_halton(rays, base) for base in (2, 3, 5, 7)], axis=-1)
    pitch = rig.panel.pixel_pitch_um / 1000
    for setup in setups(rig):
        centres = pixel_centres(setup)
        shift = random.random((*centres.shape[:2], 1, 4))
        for start in range(0, rays, _RAYS_AT_ONCE):
            s = (points[start : start + _RAYS_AT_ONCE] + shift) % 1.0
            X = centres[:, :, None] + (s[..., :2] - 0.5) * pitch
            radius = setup.eye.pupil_mm / 2 * np.sqrt(s[..., 2])
            angle = 2 * pi * s[..., 3]
            u = np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=-1)
            u = u + np.array(setup.eye.pupil_offset_mm)
            for colour in range(3):
                if colour == 0 or setup.eye.chromatic or rig.headset.glass or rig.array.lenslet:
                    x, through = trace(setup.of(colour), colour, X, u)
                light = emitted(setup, panel, colour, x) * through
                out[:, setup.columns, colour] += light.sum(axis=-1)
    return out / rays


def _bilinear(setup: Setup, target: Points, colour: int, X: Points) -> Points:
    given = setup.rig.panel
    pitch = given.pixel_pitch_um / 1000
    half = target[:, setup.columns, colour]
    across = (X[..., 0] + setup.axis[0]) / pitch + given.width_px / 2 - setup.columns.start
    down = given.height_px / 2 - (X[..., 1] + setup.axis[1]) / pitch
    height, width = half.shape
    inside = (across >= 0) & (across <= width) & (down >= 0) & (down <= height)
    i, j = np.floor(across - 0.5), np.floor(down - 0.5)
    light = np.zeros(across.shape)
    for di, dj in ((0, 0), (1, 0), (0, 1), (1, 1)):
        weight = (1 - np.abs(across - 0.5 - i - di)) * (1 - np.abs(down - 0.5 - j - dj))
        ii = np.clip(np.nan_to_num(i + di), 0, width - 1).astype(int)
        jj = np.clip(np.nan_to_num(j + dj), 0, height - 1).astype(int)
        light += weight * half[jj, ii]
    return np.where(inside, light, 0.0)


def forward(target: Points, rig: Rig) -> Points:
    """The panel image of the forward prefilter."""
    if rig.array.kind == "none":
        return target.copy()
    out, k = np.zeros(target.shape), rig.prefilter.subpixel_grid
    pitch = rig.panel.pixel_pitch_um / 1000
    places = (np.arange(k) + 0.5) / k - 0.5
    for named in setups(rig):
        o = np.array(named.eye.pupil_offset_mm)
        for colour in range(3):
            setup = named.of(colour)
            j, i = np.mgrid[: rig.panel.height_px, setup.columns.start : setup.columns.stop, :1][:2]
            left, top, right, bottom, _ = emitter(rig.panel.subpixels, colour, i, j)
            across, up = (each.ravel() for each in np.meshgrid(places, places))
            across = (left + right - 1) / 2 + (right - left) * across
            up = (1 - top - bottom) / 2 + (bottom - top) * up
            place = np.stack(np.broadcast_arrays(across, up), -1)
            x = pixel_centres(setup)[:, :, None] + pitch * place
            y = (x * setup.reach + setup.gap * o) / setup.m
            cell = nearest_centre(setup, to_lattice(setup, y))
            c = from_lattice(setup, cell)
            beta = (x - c) / setup.gap
            h = c - setup.to_array * beta
            alpha = beta + setup.lens * h
            u = h - setup.relief * alpha
            X = named.m * (alpha - aberration(setup, colour, u))
            met = np.hypot(*np.moveaxis(u - o, -1, 0)) <= setup.eye.pupil_mm / 2
            # The chief ray that chose the lenslet runs along its converging walls.
            if rig.array.barriers == "perpendicular":
                met &= passes_walls(setup, cell, x)
            met = met & (right > left)
            light = (_bilinear(setup, target, colour, X) * met).sum(-1)
            out[:, setup.columns, colour] = light / np.maximum(met.sum(-1), 1)
    return out
