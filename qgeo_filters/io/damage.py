"""What other libraries' readers raise on a damaged file: the file's fault, to be said as a `MeshError`.

Not among them: `OSError` (the disk's), `MemoryError` and `ImportError`, which keep their own words.
"""

from __future__ import annotations

import struct
import zlib

DAMAGED_FILE: tuple[type[Exception], ...] = (
    ArithmeticError,
    AttributeError,
    EOFError,
    LookupError,
    RuntimeError,
    SyntaxError,  # NumPy's, from a type that is none
    TypeError,
    ValueError,
    struct.error,
    zlib.error,
)
