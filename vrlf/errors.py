"""The one family of errors: each is one line that says what, what was found, what is wanted.

``exit_code`` is the status the command line leaves with: 2 where the user can
mend the input, 1 for everything else.
"""

from __future__ import annotations


class VrlfError(Exception):
    """Base of all errors that vrlf raises on purpose."""

    exit_code: int = 1

    def __str__(self) -> str:
        return " ".join(str(self.args[0]).split()) if self.args else type(self).__name__


class InputError(VrlfError):
    """Something the user gave cannot be used: a file, a value, a rig."""

    exit_code = 2


class RigError(InputError):
    """A rig file or an override is wrong; all of its wrong keys are in ``problems``.

    Parameters
    ----------
    source : str
        The file or option that was read.
    problems : sequence of str
        One entry a wrong key: ``key: found ..., wanted ...``.
    """

    def __init__(self, source: str, problems: list[str] | tuple[str, ...]) -> None:
        self.source = source
        self.problems = tuple(problems)
        super().__init__(f"{source}: " + "; ".join(self.problems))


class ImageReadError(InputError):
    """A picture cannot be read, or is not what was asked for."""


class OutputError(VrlfError):
    """A result cannot be written: a full disk, a failing encoder."""


class OutputPathError(InputError):
    """The place named for a result cannot hold it: no such folder, no rights, unknown ending."""


class DeviceError(VrlfError):
    """No usable GPU context, or the GPU reported a fault."""


class ShaderError(DeviceError):
    """A shader does not compile, or its blocks differ from their declaration."""
