"""How much a compressed file may grow when it is unpacked."""

from __future__ import annotations

_TIMES, _ALWAYS = 100, 64 << 20


def most_inflated(size: int) -> int:
    """Largest number of bytes that a file of a size is unpacked to: memory stays bounded by what is there.

    Tables of numbers shrink to a hundredth only where they say nothing; deflate can go to a thousandth.
    """
    return _ALWAYS + _TIMES * size
