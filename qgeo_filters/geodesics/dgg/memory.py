"""Memory that has been freed, back to the system."""

from __future__ import annotations

import ctypes
import sys


def release_freed_memory() -> None:
    """Have the C library return what it keeps of freed arrays, before a matrix as large as memory is begun.

    glibc keeps the temporary arrays of worker threads for later; a third of a small matrix was measured.
    Other C libraries have no such call and need none.
    """
    if sys.platform == "linux":
        trim = getattr(ctypes.CDLL(None), "malloc_trim", None)
        if trim is not None:
            trim(0)
