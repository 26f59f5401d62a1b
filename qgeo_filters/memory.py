"""Memory: how much there is for a result, refusal of what cannot fit, and what has been freed back to the system."""

from __future__ import annotations

import contextlib
import ctypes
import os
import sys
from pathlib import Path

from qgeo_filters.errors import TooLargeError

# What is left to the rest of a computation, as a fraction of what is free.
_MARGIN = 0.9
#: Where Linux keeps the limits of the container that the process is in.
CONTROL_GROUP = Path("/sys/fs/cgroup")


def require_memory(size: int, what: str, advice: str) -> None:
    """Raise `TooLargeError` before a result of so many bytes is begun that does not fit into the memory that is free.

    Parameters
    ----------
    size : int
        Bytes.
    what : str
        The result, subject of the sentence: "the distances between all 500000 vertices".
    advice : str
        What takes less.
    """
    free = available_memory()
    if free is not None and size > _MARGIN * free:
        raise TooLargeError(
            f"{what} would take {size / 1e9:.3g} GB, and {free / 1e9:.3g} GB of memory are free; {advice}"
        )


def available_memory() -> int | None:
    """Bytes that this process can still have without swapping; None where the system does not say.

    The least of what the machine has free, of what its container is allowed, and of the limit on the process's own
    address space. On macOS, which tells what there is and not what is free, half of that.
    """
    known = [size for size in (_of_machine(), _of_container(), _of_process()) if size is not None]
    return max(min(known), 0) if known else None


def release_freed_memory() -> None:
    """Have the C library return what it keeps of freed arrays, before a matrix as large as memory is begun.

    glibc keeps the temporary arrays of worker threads for later; a third of a small matrix was measured.
    Other C libraries have no such call and need none.
    """
    if sys.platform == "linux":
        trim = getattr(ctypes.CDLL(None), "malloc_trim", None)
        if trim is not None:
            trim(0)


def _of_machine() -> int | None:
    with contextlib.suppress(OSError, ValueError, IndexError):
        for line in Path("/proc/meminfo").read_text().splitlines():
            if line.startswith("MemAvailable:"):
                return 1024 * int(line.split()[1])
    if sys.platform == "win32":
        return _of_windows()
    with contextlib.suppress(OSError, ValueError, AttributeError):
        return os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE") // 2
    return None


def _of_windows() -> int | None:
    # MEMORYSTATUSEX: two 32-bit numbers, the first its own size, then seven of 64 bits, the second what is free.
    state = (ctypes.c_uint64 * 8)()
    ctypes.cast(state, ctypes.POINTER(ctypes.c_uint32))[0] = ctypes.sizeof(state)
    windows = getattr(ctypes, "windll", None)
    told = windows is not None and windows.kernel32.GlobalMemoryStatusEx(ctypes.byref(state))
    return int(state[2]) if told else None


def _of_container() -> int | None:
    """What the control group of a container leaves; files that are cached there give way."""
    with contextlib.suppress(OSError, ValueError):
        most = int((CONTROL_GROUP / "memory.max").read_text())  # "max" where there is no limit
        used = int((CONTROL_GROUP / "memory.current").read_text())
        stated = dict(line.split() for line in (CONTROL_GROUP / "memory.stat").read_text().splitlines())
        return most - used + int(stated.get("inactive_file", 0))
    return None


def _of_process() -> int | None:
    with contextlib.suppress(ImportError, OSError, ValueError):
        import resource

        most = resource.getrlimit(resource.RLIMIT_AS)[0]
        if most != resource.RLIM_INFINITY:
            pages = int(Path("/proc/self/statm").read_text().split()[0])
            return most - pages * resource.getpagesize()
    return None
