"""The wearer's eye: its prescription, pupil, accommodation and wavefront."""

from __future__ import annotations

from typing import Annotated, Final, Literal

from pydantic import BaseModel, ValidationInfo, field_validator

from vrlf.model.fields import GIVEN, FromList, above, beside, between, refusal
from vrlf.model.zernike import Zernike
from vrlf.units import MM_PER_M

# The strongest lenses that are ground lie near -40 D and 20 D of cylinder.
SPHERE_LIMIT_D: Final = 40.0
CYLINDER_LIMIT_D: Final = 20.0
AXIS_LIMIT_DEG: Final = 180.0
# Of a diameter, that is no difference.
_ROUNDING: Final = 1e-9

_Offset = Annotated[float, between(-20.0, 20.0)]
_Prism = Annotated[float, between(-100.0, 100.0)]


class Camera(BaseModel):
    """A camera in an eye's place, as one that photographs a prototype (T 5.2).

    Attributes
    ----------
    focal_mm, f_number : float
        The pupil is ``focal_mm / f_number`` wide.
    focus_mm : float or None
        Distance from the lens of the plane that is sharp; None is infinity.
    """

    model_config = GIVEN

    focal_mm: Annotated[float, between(0.5, 1000.0)]
    f_number: Annotated[float, between(0.5, 64.0)]
    focus_mm: Annotated[float, between(0.6, 1.0e6)] | None = None

    @field_validator("focus_mm", mode="after")
    @classmethod
    def _beyond_the_focal_length(cls, focus_mm: float | None, info: ValidationInfo) -> float | None:
        focal_mm = info.data.get("focal_mm")
        if focus_mm is not None and focal_mm is not None and focus_mm <= focal_mm:
            raise refusal(f"more than the focal length of {focal_mm:g} mm")
        return focus_mm


class Eye(BaseModel):
    """One eye as the rig file describes it.

    Attributes
    ----------
    sphere_d, cylinder_d : float
        Spectacle prescription in dioptres, in plus or minus cylinder form.
    axis_deg : float
        Cylinder axis in degrees, TABO: as the examiner sees it.
    vertex_mm : float
        Distance of the spectacle lens from the eye's own plane.
    pupil_mm : float
        Pupil diameter.
    pupil_offset_mm : (float, float)
        Pupil centre from the optical axis, right and up as the wearer sees it.
    prism_pd : (float, float)
        Prism dioptres that move the panel image right and up.
    accommodation : {"relaxed", "best"}
        Whether the eye focuses on the panel image as well as its age allows.
    age_years : float or None
        Age, for the amplitude of accommodation.
    chromatic : bool
        Whether the eye's power varies with the wavelength.
    luminance_cd_m2 : float or None
        What the eye is adapted to: its pupil is then as wide as that light and its age make it,
        whatever ``pupil_mm`` says.
    stiles_crawford_per_mm2 : float
        rho of the Stiles-Crawford effect: light that enters r mm off the pupil's centre counts
        10^(-rho r^2) as much. 0.05 is typical (Applegate & Lakshminarayanan 1993), 0 none.
    zernike : Zernike or None
        Measured wavefront, added to the prescription.
    camera : Camera or None
        A camera in the eye's place; of the eye's own keys only ``pupil_offset_mm`` still counts.
    """

    model_config = GIVEN

    sphere_d: Annotated[float, between(-SPHERE_LIMIT_D, SPHERE_LIMIT_D)] = 0.0
    cylinder_d: Annotated[float, between(-CYLINDER_LIMIT_D, CYLINDER_LIMIT_D)] = 0.0
    axis_deg: Annotated[float, between(0.0, AXIS_LIMIT_DEG)] = 0.0
    vertex_mm: Annotated[float, between(0.0, 100.0)] = 12.0
    pupil_mm: Annotated[float, above(0.0, 12.0)] = 6.0
    pupil_offset_mm: Annotated[tuple[_Offset, _Offset], FromList] = (0.0, 0.0)
    prism_pd: Annotated[tuple[_Prism, _Prism], FromList] = (0.0, 0.0)
    accommodation: Literal["relaxed", "best"] = "relaxed"
    age_years: Annotated[float, between(0.0, 120.0)] | None = None
    chromatic: bool = False
    luminance_cd_m2: Annotated[float, above(0.0, 1.0e5)] | None = None
    stiles_crawford_per_mm2: Annotated[float, between(0.0, 1.0)] = 0.0
    zernike: Zernike | None = None
    camera: Camera | None = None

    @field_validator("vertex_mm", mode="after")
    @classmethod
    def _vertex_before_the_focus(cls, vertex_mm: float, info: ValidationInfo) -> float:
        """The spectacle's focus must lie behind the eye, or F / (1 - v F) has no meaning."""
        sphere_d = info.data.get("sphere_d", 0.0)
        cylinder_d = info.data.get("cylinder_d", 0.0)
        strongest_d = max(sphere_d, sphere_d + cylinder_d)
        if vertex_mm * strongest_d >= MM_PER_M:
            raise refusal(
                f"less than {MM_PER_M / strongest_d:.4g} mm, the focal length of {strongest_d:g} D"
            )
        return vertex_mm

    @field_validator("zernike", mode="after")
    @classmethod
    def _measured_over_the_pupil(
        cls, zernike: Zernike | None, info: ValidationInfo
    ) -> Zernike | None:
        """Polynomials run away beyond the disc they were fitted over."""
        pupil_mm = info.data.get("pupil_mm")
        if zernike is None or pupil_mm is None or zernike.extrapolate:
            return zernike
        if pupil_mm > zernike.diameter_mm * (1.0 + _ROUNDING):
            raise refusal(
                f"at most {zernike.diameter_mm:g} mm, over which the wavefront was measured "
                "(or zernike.extrapolate = true)",
                key=beside("pupil_mm"),
                found=f"{pupil_mm:g}",
            )
        return zernike
