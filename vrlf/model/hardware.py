"""What the wearer holds before the eyes: panel, headset and array."""

from __future__ import annotations

from math import sqrt
from typing import Annotated, Any, Final, Literal

from pydantic import AfterValidator, BaseModel, Field, ValidationInfo, field_validator

from vrlf.model.fields import GIVEN, FromList, between, refusal
from vrlf.model.glasses import glasses
from vrlf.model.layouts import layout_names, names_wanted
from vrlf.model.lenslet import Lenslet, design_power_per_mm
from vrlf.units import MM_PER_M

# A pitch that varies stays between these shares of the middle one: less would turn back.
LEAST_PITCH: Final = 0.5
MOST_PITCH: Final = 2.0

ArrayKind = Literal["microlens", "pinhole", "none"]

# A focal length that is given beside a lenslet's surfaces may be rounded to three digits.
_ROUNDED: Final = 0.005
# Key of [array], the kinds that need it, the least and the most it may be.
_NEEDED: Final[dict[str, tuple[tuple[ArrayKind, ...], float, float]]] = {
    "pitch_um": (("microlens", "pinhole"), 1.0, 100_000.0),
    "gap_mm": (("microlens", "pinhole"), 0.001, 10_000.0),
    "focal_mm": (("microlens",), 0.001, 1_000_000.0),
    "aperture_um": (("pinhole",), 0.1, 100_000.0),
    "gap_index": (("microlens", "pinhole"), 1.0, 3.0),
}
# Side of the largest upright square in a regular hexagon that stands on a corner, by the distance
# of its opposite sides: its corner (s/2, s/2) lies on the border at 60 degrees, s (1 + root 3) / 4
# from the centre.
_SQUARE_IN_HEXAGON: Final = sqrt(3.0) - 1.0

_Wavelength = Annotated[float, between(380.0, 780.0)]
_Unit = Annotated[float, between(0.0, 1.0)]
_Chromaticity = Annotated[tuple[_Unit, _Unit], FromList]
_Distortion = Annotated[float, between(-100.0, 100.0)]
_Growth = Annotated[float, between(-10.0, 10.0)]
_Offset = Annotated[float, between(-1_000_000.0, 1_000_000.0)]


def _known_layout(name: str) -> str:
    if name not in layout_names():
        raise refusal(names_wanted())
    return name


def _named_layouts(schema: dict[str, Any]) -> None:
    schema["enum"] = list(layout_names())


class Primaries(BaseModel):
    """Where a panel's red, green, blue and white lie in the CIE 1931 diagram, (x, y)."""

    model_config = GIVEN

    red: _Chromaticity
    green: _Chromaticity
    blue: _Chromaticity
    white: _Chromaticity


class Panel(BaseModel):
    """The display: ``width_px`` by ``height_px`` pixels of ``pixel_pitch_um``.

    Attributes
    ----------
    width_px, height_px : int
    pixel_pitch_um : float
    subpixels : str
        Names the layout of the emitting areas.
    wavelengths_nm : (float, float, float)
        What red, green and blue emit.
    peak_nit : float
        Luminance of full drive, cd/m^2.
    bits : int
        Of each colour: a panel image is written in as many steps.
    primaries : Primaries or None
        For information: light is the panel's own red, green and blue throughout.
    """

    model_config = GIVEN

    width_px: Annotated[int, between(2, 32_768)]
    height_px: Annotated[int, between(2, 32_768)]
    pixel_pitch_um: Annotated[float, between(0.5, 10_000.0)]
    subpixels: Annotated[
        str, AfterValidator(_known_layout), Field(json_schema_extra=_named_layouts)
    ] = "rgb-stripe"
    wavelengths_nm: Annotated[tuple[_Wavelength, _Wavelength, _Wavelength], FromList] = (
        610.0,
        545.0,
        465.0,
    )
    peak_nit: Annotated[float, between(1.0, 100_000.0)] = 500.0  # the iPhone 6's, by Apple
    bits: Literal[8, 10] = 8
    primaries: Primaries | None = None


class Headset(BaseModel):
    """The frame that holds a lens for each eye before the panel.

    Attributes
    ----------
    lens_to_panel_mm : float
        Physical distance along the axis.
    lens_separation_mm, lens_height_mm : float
        Distance between the two axes, and their height above the panel's middle.
    lens_power_d : float or None
        Power of each lens; None puts the bare panel at its focus, 0 is no lens.
        `lens_power_d` resolves it.
    eye_relief_mm : float
        Lens to pupil; 0 is the single-lens approximation.
    distortion : (float, float) or None
        k1 and k2 of r (1 + k1 r^2 + k2 r^4), r the panel slope.
    glass : str or None
        What the lenses are made of, a name of assets/glasses.toml: their power then is that
        of 589 nm and another for each colour of the panel. None is one power for all.
    """

    model_config = GIVEN

    lens_to_panel_mm: Annotated[float, between(1.0, 10_000.0)]
    lens_separation_mm: Annotated[float, between(0.0, 1000.0)] = 62.0
    lens_height_mm: Annotated[float, between(-1000.0, 1000.0)] = 0.0
    lens_power_d: Annotated[float, between(-100.0, 1000.0)] | None = None
    eye_relief_mm: Annotated[float, between(0.0, 1000.0)] = 0.0
    distortion: Annotated[tuple[_Distortion, _Distortion], FromList] | None = None
    glass: str | None = None

    @field_validator("glass", mode="after")
    @classmethod
    def _in_the_catalogue(cls, glass: str | None) -> str | None:
        if glass is not None and glass not in glasses():
            raise refusal("one of " + ", ".join(f'"{name}"' for name in glasses()))
        return glass


def lens_power_d(headset: Headset) -> float:
    """Power of the headset's lenses in dioptres; by default the panel stands at their focus."""
    if headset.lens_power_d is None:
        return MM_PER_M / headset.lens_to_panel_mm
    return headset.lens_power_d


class Array(BaseModel):
    """The pinhole or microlens array before the panel, or none.

    With ``kind = "none"`` the other keys mean nothing, so no length is demanded
    and none is judged; a length of 0 stands for one that was not given.

    Attributes
    ----------
    kind : {"microlens", "pinhole", "none"}
    pitch_um : float
        Distance between neighbouring cells of the lattice.
    lattice : {"square", "hexagonal"}
        A hexagonal one's second axis stands 60 degrees to its first.
    gap_mm, gap_index : float
        Thickness and refractive index of what is between array and panel.
    lenslet : Lenslet or None
        A lenslet's surfaces; None is an ideal one of ``focal_mm``.
    focal_mm : float
        Focal length of the lenslets; 0 where it follows from ``lenslet``. `focal_mm` resolves it.
    aperture_um, aperture_shape : float, {"square", "circle"}
        Side or diameter of the holes.
    offset_um : (float, float)
        Shift of the lattice along the panel's axes, right and up.
    rotation_deg : float
        Turn of the lattice, anticlockwise as the wearer sees it.
    barriers : {"none", "perpendicular", "converging"}
        Walls between the cells.
    pitch_growth_per_cm2 : (float, float)
        Of columns and of rows: column k stands t (1 + G t^2 / 3) from the lattice's middle, with
        t = k pitch, so that there the pitch is (1 + G t^2) as wide. Borders stand half-way in k.
        Square lattices that are not turned only.
    """

    model_config = GIVEN

    # First, because the checks of the other keys ask for it; so they do for pitch and shapes.
    kind: ArrayKind
    pitch_um: float = Field(default=0.0, validate_default=True)
    lattice: Literal["square", "hexagonal"] = "square"
    gap_mm: float = Field(default=0.0, validate_default=True)
    gap_index: float = 1.0
    aperture_shape: Literal["square", "circle"] = "square"
    aperture_um: float = Field(default=75.0, validate_default=True)
    lenslet: Lenslet | None = None
    focal_mm: float = Field(default=0.0, validate_default=True)
    offset_um: Annotated[tuple[_Offset, _Offset], FromList] = (0.0, 0.0)
    rotation_deg: Annotated[float, between(-360.0, 360.0)] = 0.0
    barriers: Literal["none", "perpendicular", "converging"] = "none"
    pitch_growth_per_cm2: Annotated[tuple[_Growth, _Growth], FromList] = (0.0, 0.0)

    @property
    def varies(self) -> bool:
        """Whether the pitch does, over the panel."""
        return self.kind != "none" and self.pitch_growth_per_cm2 != (0.0, 0.0)

    @field_validator(*_NEEDED, mode="after")
    @classmethod
    def _needed_by_the_kind(cls, value: float, info: ValidationInfo) -> float:
        kinds, least, most = _NEEDED[info.field_name or ""]
        kind = info.data.get("kind", "none")
        if info.field_name == "focal_mm" and kind == "microlens":
            if "lenslet" not in info.data or "gap_index" not in info.data:
                return value  # what is wrong there is said there
            if info.data["lenslet"] is not None:
                _check_focal(value, info.data["lenslet"], info.data["gap_index"])
                return value
        if kind in kinds and not least <= value <= most:
            raise refusal(f'a number from {least:g} to {most:g} for kind "{kind}"')
        return value

    @field_validator("pitch_growth_per_cm2", mode="after")
    @classmethod
    def _grows_along_the_panel(
        cls, growth: tuple[float, float], info: ValidationInfo
    ) -> tuple[float, float]:
        given = info.data
        if given.get("kind") == "none" or growth == (0.0, 0.0):
            return growth
        if given.get("lattice") == "hexagonal" or given.get("rotation_deg") != 0.0:
            raise refusal("[0, 0] unless the lattice is square and rotation_deg 0")
        return growth

    @field_validator("aperture_um", mode="after")
    @classmethod
    def _holes_inside_cells(cls, aperture_um: float, info: ValidationInfo) -> float:
        pitch_um = info.data.get("pitch_um")
        if info.data.get("kind") != "pinhole" or not pitch_um:
            return aperture_um
        if aperture_um > pitch_um:
            raise refusal(f"at most the pitch of {pitch_um:g} um")
        is_hexagonal = info.data.get("lattice") == "hexagonal"
        if is_hexagonal and info.data.get("aperture_shape") == "square":
            most_um = pitch_um * _SQUARE_IN_HEXAGON
            if aperture_um > most_um:
                raise refusal(f"at most {most_um:.6g} um: larger squares pass a hexagonal cell")
        return aperture_um


def focal_mm(array: Array) -> float:
    """Focal length of the array's lenslets at the d line: what their surfaces make of it, or given.

    Behind a solid spacer it is the reduced one, as the gap that the ray equations know.
    """
    if array.lenslet is None:
        return array.focal_mm
    return 1.0 / design_power_per_mm(array.lenslet, array.gap_index)


def _check_focal(focal_mm: float, lenslet: Lenslet, gap_index: float) -> None:
    """Refuse surfaces that focus nothing, and another focal length beside them."""
    _, least, most = _NEEDED["focal_mm"]
    power = design_power_per_mm(lenslet, gap_index)
    if not 1.0 / most <= power <= 1.0 / least:
        raise refusal(
            f"a focal length from {least:g} to {most:g} mm",
            key="array.lenslet",
            found="surfaces of none" if power <= 0.0 else f"surfaces of {1.0 / power:.4g} mm",
        )
    if focal_mm != 0.0 and abs(focal_mm * power - 1.0) > _ROUNDED:
        raise refusal(f"{1.0 / power:.4g}, what array.lenslet makes of it, or no focal_mm")
