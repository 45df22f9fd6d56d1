"""The page that a phone opens: one file, its script and style inside, nothing else to fetch."""

from __future__ import annotations

import base64
import hashlib
from functools import cache

from vrlf.resources import assets_dir


@cache
def page() -> bytes:
    """The whole page, UTF-8."""
    return _page()[0].encode()


@cache
def page_headers() -> tuple[tuple[str, str], ...]:
    """Headers of every answer: what the page may do, and that nobody else may frame or keep it."""
    _, script, style = _page()
    policy = (
        f"default-src 'none'; script-src {_hash(script)}; style-src {_hash(style)}; "
        "connect-src 'self' ws: wss:; img-src data:; base-uri 'none'; form-action 'none'; "
        "frame-ancestors 'none'"
    )
    return (
        ("Content-Security-Policy", policy),
        ("Referrer-Policy", "no-referrer"),
        ("X-Content-Type-Options", "nosniff"),
        ("X-Frame-Options", "DENY"),
        ("Cross-Origin-Opener-Policy", "same-origin"),
        ("Cross-Origin-Resource-Policy", "same-origin"),
        ("Cache-Control", "no-store"),
        (
            "Permissions-Policy",
            "accelerometer=(self), gyroscope=(self), magnetometer=(self), fullscreen=(self), "
            "screen-wake-lock=(self), gamepad=(self), camera=(), microphone=(), geolocation=()",
        ),
    )


@cache
def _page() -> tuple[str, str, str]:
    folder = assets_dir() / "phone"
    script = (folder / "phone.js").read_text(encoding="utf-8")
    style = (folder / "phone.css").read_text(encoding="utf-8")
    whole = (folder / "phone.html").read_text(encoding="utf-8")
    return whole.replace("/*STYLE*/", style).replace("/*SCRIPT*/", script), script, style


def _hash(text: str) -> str:
    return f"'sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}'"
