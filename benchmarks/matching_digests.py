"""Digests of ten maps and ten symmetries of the tuning categories: what a change of plumbing must leave bit for bit.

    python benchmarks/matching_digests.py ROOT > before.txt    # ROOT: the folder that holds remeshed/
    python benchmarks/matching_digests.py ROOT | diff before.txt -

Digests depend on the processor and its BLAS: compare those of one machine only.
"""

from __future__ import annotations

import argparse
import hashlib
from pathlib import Path

import numpy as np

import qgeo_filters as qg

PAIRS = (
    ("cat0", "cat1"), ("cat0", "cat9"), ("cat3", "cat6"), ("cat8", "cat5"),
    ("dog0", "dog3"), ("dog1", "dog5"), ("dog6", "dog2"),
    ("centaur0", "centaur1"), ("centaur2", "centaur5"), ("centaur4", "centaur3"),
)  # fmt: skip
MAP = ("p2p", "inverse", "functional_map", "positions", "margin", "orientation", "confident")
SYMMETRY = ("found", "p2p", "nearest", "side", "asymmetry", "epsilon", "regions")


def digest(result: object, fields: tuple[str, ...]) -> str:
    """The first sixteen figures of SHA-256 over some fields of a result."""
    sha = hashlib.sha256()
    for field in fields:
        values = np.ascontiguousarray(getattr(result, field))
        sha.update(f"{field} {values.dtype} {values.shape}".encode())
        sha.update(values.tobytes())
    return sha.hexdigest()[:16]


def main() -> None:
    """Print a line for each map and for each symmetry of a pair's first shape."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("root", type=Path)
    parser.add_argument("--pairs", type=int, default=len(PAIRS), help="only the first so many")
    arguments = parser.parse_args()
    for one, other in PAIRS[: arguments.pairs]:
        x, y = (qg.Surface.read(arguments.root / "remeshed" / f"{name}.off") for name in (one, other))
        print(f"{one}-{other} {digest(qg.match(x, y), MAP)} {digest(qg.self_symmetry(x), SYMMETRY)}", flush=True)


if __name__ == "__main__":
    main()
