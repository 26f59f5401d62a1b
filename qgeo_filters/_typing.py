"""Array types, each with one meaning throughout the package; shapes stand in the docstrings."""

from __future__ import annotations

from typing import Literal, TypeAlias

import numpy as np
import numpy.typing as npt

#: Coordinates, lengths, areas, eigenfunctions: whatever is computed in double precision.
FloatArray = npt.NDArray[np.float64]
#: All-pairs distances and what is made of them: single precision, to fit in memory.
SingleArray = npt.NDArray[np.float32]
#: Indices that a user sees or gives (vertices, faces, points of a map), and those that kernels count with.
IndexArray = npt.NDArray[np.int64]
#: Tables of a mesh: faces, edges, half-edges, labels of vertices.
IntArray = npt.NDArray[np.int32]
#: Whether a mesh is repaired as it is read; "auto": where something is wrong; "force": whatever has to be removed.
RepairOption: TypeAlias = bool | Literal["auto", "force", "wrap"]
#: Whether one shape is matched as a part of the other; "auto" decides from the shapes.
PartialOption: TypeAlias = bool | Literal["auto"]
MirrorOption: TypeAlias = Literal["no", "yes", "auto"]
