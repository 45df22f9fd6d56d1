"""Configuration and field types that all tables of a rig share."""

from __future__ import annotations

from typing import Any, Final

from pydantic import BeforeValidator, ConfigDict, Field
from pydantic_core import PydanticCustomError

# One configuration for every table: nothing unknown, nothing coerced, nothing
# that is not finite, nothing changed later.
GIVEN: Final = ConfigDict(extra="forbid", frozen=True, strict=True, allow_inf_nan=False)


def _tuple_from_list(value: Any) -> Any:
    """TOML knows lists only; strict validation of a tuple would refuse them."""
    return tuple(value) if isinstance(value, list) else value


FromList: Final = BeforeValidator(_tuple_from_list)


def between(low: float, high: float) -> Any:
    """Closed interval of allowed numbers, for ``Annotated[float, between(0, 180)]``."""
    return Field(ge=low, le=high)


def above(low: float, high: float) -> Any:
    """Half-open interval: more than ``low``, up to ``high``."""
    return Field(gt=low, le=high)


def beside(name: str) -> str:
    """The key of a neighbour in the same table, whichever table that is, for `refusal`."""
    return f"*.{name}"


def refusal(
    wanted: str, *, key: str | None = None, found: str | None = None
) -> PydanticCustomError:
    """Error of a check between fields; `vrlf.model.complaints` words it.

    Parameters
    ----------
    wanted : str
        What the rig may hold instead.
    key : str, optional
        Full key to blame, or `beside`, where it is not the field under validation.
    found : str, optional
        What was found, where the value in the file does not say it.
    """
    context: dict[str, Any] = {"wanted": wanted}
    if key is not None:
        context["key"] = key
    if found is not None:
        context["found"] = found
    return PydanticCustomError("refusal", "wanted {wanted}", context)
