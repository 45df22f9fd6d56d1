"""Where a phone finds us: the listening socket, the address with its token, the QR code."""

from __future__ import annotations

import io
from collections.abc import Callable
from pathlib import Path

import segno

from vrlf.app.preview.state import state_folder
from vrlf.app.serve.address import LOOPBACK, addresses, hosts, in_address, listen
from vrlf.app.serve.certificate import fingerprint, names_of, own_certificate, tls_context
from vrlf.app.serve.door import Door, new_token
from vrlf.app.serve.server import Plan
from vrlf.app.serve.wire import ENCODINGS
from vrlf.model import Rig


class Where:
    """Owns the listening socket; knows the address that a phone is given."""

    def __init__(self, host: str, port: int, cert: str | None, key: str | None) -> None:
        self.socket = listen(host, port)
        try:
            self.port = self.socket.getsockname()[1]
            found = addresses(host)
            self._files: tuple[Path, Path] | None = None
            if cert is not None and key is not None:
                self._files = (Path(cert), Path(key))
            elif not found.is_loopback:
                self._files = own_certificate(state_folder() / "serve", found.all)
            if self._files is not None:
                tls_context(*self._files)  # a wrong one is said now
            self._is_own = cert is None
            scheme = "https" if self._files else "http"
            # Their own certificate is for a name, and that is what the phone must ask for.
            named = names_of(self._files[0]) if self._files and cert is not None else ()
            known = hosts((*found.all, *named), self.port, scheme)
            self.door = Door(new_token(), known, scheme)
            best = named[0] if named else found.best
            self.url = f"{scheme}://{in_address(best, self.port)}{self.door.path}"
            self.is_stranded = not found.is_loopback and best == LOOPBACK
        except BaseException:
            self.socket.close()
            raise

    def plan_of(self, rig: Rig, encoding: str) -> Callable[[str, int], Plan]:
        """For the server's process."""

        def plan(slots_name: str, most_pixels: int) -> Plan:
            cert, key = self._files or (None, None)
            encodings = ENCODINGS if encoding == "auto" else (encoding,)
            panel_px = rig.panel.width_px, rig.panel.height_px
            door = self.door
            return Plan(door, slots_name, most_pixels, panel_px, cert, key, encodings)

        return plan

    def words(self, *, has_qr: bool) -> list[str]:
        """What the phone will ask about, and the address as a QR code for a terminal."""
        found = []
        if self._files and self._is_own:
            found.append(
                f"the phone warns once of this certificate, SHA-256 {fingerprint(self._files[0])}"
            )
        if self.is_stranded:
            found.append("found no way into a network: no phone reaches this address")
        if has_qr:
            text = io.StringIO()
            segno.make(self.url, micro=False).terminal(out=text, compact=True)
            found.append(text.getvalue())
        return found

    def modules(self) -> tuple[tuple[bool, ...], ...]:
        """The same QR code, row by row, a module each; True is dark."""
        matrix = segno.make(self.url, micro=False).matrix_iter(border=4)
        return tuple(tuple(bool(each) for each in row) for row in matrix)

    def close(self) -> None:
        """Give the socket back."""
        self.socket.close()
