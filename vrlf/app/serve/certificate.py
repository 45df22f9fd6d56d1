"""The TLS certificate that is made on first use: phones give motion sensors to secure pages only.

It is signed by itself, so a phone's browser warns once; the fingerprint that ``vrlf serve`` prints
is what it then shows. Its key never leaves the user's folder and is readable by the user alone.
"""

from __future__ import annotations

import importlib.util
import ipaddress
import os
import ssl
from collections.abc import Iterable
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

from vrlf.errors import DeviceError, InputError, OutputError
from vrlf.files import make_folder, shown

_DAYS = 397  # what browsers accept at most
_CERT, _KEY = "certificate.pem", "key.pem"


def own_certificate(folder: Path, names: Iterable[str]) -> tuple[Path, Path]:
    """The certificate and key in ``folder`` for these host names and addresses; made if missing.

    Raises
    ------
    DeviceError
        If the library that makes one is not installed.
    OutputError
        If it cannot be written.
    """
    wanted = frozenset(names)
    cert, key = folder / _CERT, folder / _KEY
    if not _serves(cert, key, wanted):
        _make(folder, wanted)
    return cert, key


def tls_context(cert: Path, key: Path) -> ssl.SSLContext:
    """For a server.

    Raises
    ------
    InputError
        If the two files are not a certificate and its key.
    """
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    context.minimum_version = ssl.TLSVersion.TLSv1_2
    for path in (cert, key):
        if not path.is_file():
            raise InputError(f"{shown(path)}: found no such file, wanted a PEM file")
    try:
        # A password would be asked for on the terminal.
        context.load_cert_chain(cert, key, password=lambda: b"")
    except (OSError, ValueError) as error:
        reason = getattr(error, "reason", None) or error
        raise InputError(
            f"{shown(cert)}, {shown(key)}: found '{reason}', wanted a certificate and its key, "
            "both PEM, without a password"
        ) from error
    return context


def fingerprint(cert: Path) -> str:
    """SHA-256 of a certificate, as browsers show it."""
    from cryptography import x509
    from cryptography.hazmat.primitives.hashes import SHA256

    found = x509.load_pem_x509_certificate(cert.read_bytes())
    return found.fingerprint(SHA256()).hex(":").upper()


def names_of(cert: Path) -> tuple[str, ...]:
    """The host names that a certificate is for; none where it or the library says nothing."""
    if importlib.util.find_spec("cryptography") is None:
        return ()
    from cryptography import x509

    try:
        found = x509.load_pem_x509_certificate(cert.read_bytes())
        there = found.extensions.get_extension_for_class(x509.SubjectAlternativeName).value
    except (OSError, ValueError, x509.ExtensionNotFound):
        return ()
    return tuple(name for name in there.get_values_for_type(x509.DNSName) if "*" not in name)


def _serves(cert: Path, key: Path, wanted: frozenset[str]) -> bool:
    """Whether what lies there is ours, for all of these names, and still good."""
    _require()
    from cryptography import x509

    try:
        found = x509.load_pem_x509_certificate(cert.read_bytes())
        names = found.extensions.get_extension_for_class(x509.SubjectAlternativeName).value
        tls_context(cert, key)
    except (OSError, ValueError, InputError, x509.ExtensionNotFound):
        return False
    there = {str(name.value) for name in names}
    return wanted <= there and found.not_valid_after_utc > datetime.now(UTC) + timedelta(days=1)


def _make(folder: Path, names: frozenset[str]) -> None:
    from cryptography import x509
    from cryptography.hazmat.primitives import hashes, serialization
    from cryptography.hazmat.primitives.asymmetric import ec
    from cryptography.x509.oid import ExtendedKeyUsageOID, NameOID

    key = ec.generate_private_key(ec.SECP256R1())
    name = x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, "vrlf serve")])
    began = datetime.now(UTC) - timedelta(hours=1)
    made = (
        x509.CertificateBuilder()
        .subject_name(name)
        .issuer_name(name)
        .public_key(key.public_key())
        .serial_number(x509.random_serial_number())
        .not_valid_before(began)
        .not_valid_after(began + timedelta(days=_DAYS))
        .add_extension(
            x509.SubjectAlternativeName([_general_name(each) for each in sorted(names)]), False
        )
        .add_extension(x509.BasicConstraints(ca=False, path_length=None), True)
        .add_extension(x509.ExtendedKeyUsage([ExtendedKeyUsageOID.SERVER_AUTH]), False)
        .sign(key, hashes.SHA256())
    )
    make_folder(folder)
    secret = key.private_bytes(
        serialization.Encoding.PEM,
        serialization.PrivateFormat.PKCS8,
        serialization.NoEncryption(),
    )
    _write(folder / _KEY, secret)
    _write(folder / _CERT, made.public_bytes(serialization.Encoding.PEM))


def _general_name(name: str) -> Any:
    from cryptography import x509

    try:
        return x509.IPAddress(ipaddress.ip_address(name))
    except ValueError:
        return x509.DNSName(name)


def _write(path: Path, data: bytes) -> None:
    """Whole or not at all, and readable by the user alone from its first byte on."""
    partial = path.with_name(f".{path.name}.part")
    try:
        partial.unlink(missing_ok=True)
        descriptor = os.open(partial, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
        with os.fdopen(descriptor, "wb") as file:
            file.write(data)
        os.replace(partial, path)
    except OSError as error:
        partial.unlink(missing_ok=True)
        raise OutputError(
            f"{shown(path)}: found '{error.strerror}', wanted room for a certificate"
        ) from error


def _require() -> None:
    if importlib.util.find_spec("cryptography") is None:
        raise DeviceError(
            "serve: found no cryptography, wanted it for TLS; pip install 'vrlf[serve]', "
            "or give your own --cert and --key"
        )
