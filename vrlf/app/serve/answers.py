"""Answers to requests that open no socket."""

from __future__ import annotations

from http import HTTPStatus

from websockets.datastructures import Headers
from websockets.http11 import Response

from vrlf.app.serve.page import page_headers


def lists(headers: Headers) -> dict[str, list[str]]:
    """All values of each header, by its lower-case name."""
    names = {name.lower() for name in headers}
    return {name: headers.get_all(name) for name in names}


def answer(status: HTTPStatus, body: bytes, kind: str) -> Response:
    """With the headers of every answer; the connection ends with it."""
    headers = Headers(
        [
            *page_headers(),
            ("Content-Type", kind),
            ("Content-Length", str(len(body))),
            ("Connection", "close"),
        ]
    )
    return Response(status.value, status.phrase, headers, body)
