"""The wearer's eye: its prescription, pupil, accommodation and wavefront."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Final, Literal

from pydantic import AfterValidator, BaseModel, ValidationInfo, field_validator

from vrlf.model.fields import GIVEN, FromList, above, between, refusal
from vrlf.units import MM_PER_M

# The strongest lenses that are ground lie near -40 D and 20 D of cylinder.
SPHERE_LIMIT_D: Final = 40.0
CYLINDER_LIMIT_D: Final = 20.0
AXIS_LIMIT_DEG: Final = 180.0
ZERNIKE_ORDER_LIMIT: Final = 8

_Offset = Annotated[float, between(-20.0, 20.0)]
_Prism = Annotated[float, between(-100.0, 100.0)]


def _indices(name: str) -> tuple[int, int] | None:
    """Order and frequency of a coefficient's name, None where it is not one.

    Only the plain spelling counts, so that no two keys mean one coefficient.
    """
    try:
        n, m = (int(part) for part in name.split(","))
    except ValueError:
        return None
    real = 0 <= n <= ZERNIKE_ORDER_LIMIT and abs(m) <= n and (n - m) % 2 == 0
    return (n, m) if real and name == f"{n},{m}" else None


def _coefficient_name(name: str) -> str:
    if _indices(name) is None:
        raise refusal(
            f'a name "n,m" such as "3,-1", n from 0 to {ZERNIKE_ORDER_LIMIT}, '
            "m from -n to n in steps of 2",
            found="no such coefficient",
        )
    return name


class Zernike(BaseModel):
    """Wavefront error of an eye in normalised OSA/ANSI Z80.28 polynomials.

    Attributes
    ----------
    diameter_mm : float
        Diameter of the pupil that the coefficients belong to, in mm.
    coefficients_um : mapping of str to float
        Coefficients in micrometres by their name ``"n,m"``.
    """

    model_config = GIVEN

    diameter_mm: Annotated[float, between(0.1, 20.0)]
    coefficients_um: Mapping[
        Annotated[str, AfterValidator(_coefficient_name)],
        Annotated[float, between(-1000.0, 1000.0)],
    ]

    @property
    def terms(self) -> tuple[tuple[tuple[int, int], float], ...]:
        """Pairs ((n, m), micrometres), sorted by n, then m."""
        pairs = ((_indices(name), um) for name, um in self.coefficients_um.items())
        return tuple(sorted((nm, um) for nm, um in pairs if nm is not None))

    def __hash__(self) -> int:
        # The mapping itself has no hash, and rigs serve as keys of caches.
        return hash((self.diameter_mm, self.terms))


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
    zernike : Zernike or None
        Measured wavefront, added to the prescription.
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
    zernike: Zernike | None = None

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
