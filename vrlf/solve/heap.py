"""The process's own memory, as the operating system sees it."""

from __future__ import annotations

import ctypes
import sys


def give_back_freed() -> None:
    """Hand what was freed back to the system, where the C library offers that (glibc does).

    Making tables takes and frees many arrays of many sizes. glibc keeps what lies between
    those still in use: after 24 prescriptions a process stood at 290 MB, of which 110 were free.
    It takes 1 to 3 ms.
    """
    if sys.platform == "linux":
        trim = getattr(ctypes.CDLL(None), "malloc_trim", None)
        if trim is not None:
            trim(0)
