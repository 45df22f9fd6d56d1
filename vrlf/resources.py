"""Where the shaders and assets are: in the checkout first, then inside the installed package."""

from __future__ import annotations

from pathlib import Path

from vrlf.errors import VrlfError

_PACKAGE = Path(__file__).resolve().parent


def _folder(name: str) -> Path:
    """The folder ``name`` of a checkout, or its copy inside an installed wheel."""
    in_checkout = _PACKAGE.parent / name
    if in_checkout.is_dir() and (_PACKAGE.parent / "pyproject.toml").is_file():
        return in_checkout
    in_wheel = _PACKAGE / f"_{name}"
    if in_wheel.is_dir():
        return in_wheel
    raise VrlfError(
        f"{name}/: found neither {in_checkout} nor {in_wheel}; the installation is incomplete, "
        "install vrlf again"
    )


def shaders_dir() -> Path:
    """Folder of the GLSL sources."""
    return _folder("shaders")


def assets_dir() -> Path:
    """Folder of the shipped rigs, pictures and fonts."""
    return _folder("assets")
