"""Defaults that several floors share; this file imports nothing, so that the command line can name them."""

from __future__ import annotations

from typing import Final

#: Weight of the scalar in the lifted metric. Chosen on TOSCA's cat, dog and centaur: there .01 of the mean curvature
#: brings poses nearer (C_XY) than the Cartesian metric does, and .03 and above take them further apart
#: (`benchmarks/paper_metric.py`).
CURVATURE_WEIGHT: Final = 0.01
#: Eigenpairs of the distances: the paper's k.
EIGENPAIRS: Final = 20
#: Eigenfunctions in the measure of self-symmetry, eq. (3): the paper takes at most 20.
SYMMETRY_K0: Final = 20
