"""Landmarks: named points of a shape."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, get_args

import numpy as np
import numpy.typing as npt

from qgeo_filters._typing import FloatArray, IndexArray
from qgeo_filters.errors import ParameterError
from qgeo_filters.html_repr import card
from qgeo_filters.validation import frozen

#: Frames of anatomy: the axes point to the right, the front and the head, or to the left, the back and the head.
Frame = Literal["RAS", "LPS"]


class Landmarks:
    """Named points of a shape, as positions, as vertices, or as both.

    Parameters
    ----------
    names : sequence of str, optional
        Runs of white space become one space; "1", "2", ... by default. Names may repeat.
    points : array-like, shape (k, 3), optional
        Positions, in the unit and frame of the shape; rows of NaN where one is not known.
    vertices : array-like of int, shape (k,), optional
        Vertex of the shape, from 0, for each; -1 where it is not known.
    frame : {"RAS", "LPS"}, optional
        Frame of the positions where a file says so, see `in_frame`.

    Attributes
    ----------
    names : tuple of str
    points : (k, 3) float64
    vertices : (k,) int64
    frame : str or None

    Raises
    ------
    ParameterError
        Neither points nor vertices, lengths that differ, points that are neither finite nor NaN throughout.

    Examples
    --------
    >>> tips = qg.Landmarks(["nose", "tail"], [[0.1, 0.7, 0.2], [0.0, -0.9, 0.1]])
    >>> tips["tail"]
    array([ 0. , -0.9,  0.1])
    >>> qg.Landmarks(vertices=[17, 240])
    Landmarks(2: 1, 2)
    """

    names: tuple[str, ...]
    points: FloatArray
    vertices: IndexArray
    frame: Frame | None

    def __init__(
        self,
        names: Sequence[str] | None = None,
        points: npt.ArrayLike | None = None,
        vertices: npt.ArrayLike | None = None,
        frame: Frame | None = None,
    ) -> None:
        if points is None and vertices is None:
            raise ParameterError("landmarks need points or vertices")
        if frame is not None and frame not in get_args(Frame):
            raise ParameterError(f"the frame of landmarks is 'RAS', 'LPS' or None, got {frame!r}")
        known = np.array([] if vertices is None else vertices)
        known = known.astype(np.int64) if not known.size and known.ndim == 1 else known
        places = np.array(np.full((len(known), 3), np.nan) if points is None else points, dtype=np.float64)
        places = places.reshape(0, 3) if places.size == 0 else places
        if places.ndim != 2 or places.shape[1] != 3:
            raise ParameterError(f"landmarks must be points of shape (k, 3), got {places.shape}")
        known = np.full(len(places), -1) if vertices is None else known
        if known.dtype.kind not in "iu" or known.shape != places.shape[:1]:
            raise ParameterError(
                f"vertices of landmarks must be {len(places)} whole numbers, got {known.dtype} of shape {known.shape}"
            )
        if names is not None and len(names) != len(places):
            raise ParameterError(f"there are {len(names)} names for {len(places)} landmarks")
        bad = np.flatnonzero(~np.isfinite(places).all(axis=1) & ~np.isnan(places).all(axis=1))
        if bad.size:
            raise ParameterError(
                f"landmark {bad[0]} is at {places[bad[0]].tolist()}: neither finite nor NaN throughout"
            )
        self.__dict__.update(
            names=tuple(" ".join(str(name).split()) for name in names or range(1, len(places) + 1)),
            points=frozen(places),
            vertices=frozen(np.maximum(known, -1).astype(np.int64)),
            frame=frame,
        )

    def __setattr__(self, name: str, value: object) -> None:
        raise AttributeError(f"cannot set {name!r}: landmarks never change")

    def __len__(self) -> int:
        return len(self.names)

    def __getitem__(self, name: str) -> FloatArray:
        """Position (3,) of the first landmark of this name."""
        if name not in self.names:
            raise KeyError(f"no landmark {name!r}; there are {', '.join(self.names) or 'none'}")
        point: FloatArray = self.points[self.names.index(name)]
        return point

    def __repr__(self) -> str:
        shown = ", ".join(self.names[:6]) + (", ..." if len(self) > 6 else "")
        return f"Landmarks({len(self)}{f' in {self.frame}' if self.frame else ''}: {shown})"

    def _repr_html_(self) -> str:
        rows = [
            (name, ", ".join(f"{value:.6g}" for value in point), int(vertex) if vertex >= 0 else "-")
            for name, point, vertex in zip(self.names, self.points, self.vertices, strict=True)
        ]
        return card(f"Landmarks: {len(self)}", {"frame": self.frame}, table=rows, columns=("name", "point", "vertex"))

    @property
    def is_known(self) -> npt.NDArray[np.bool_]:
        """Whether a landmark has a position or a vertex, shape (k,)."""
        known: npt.NDArray[np.bool_] = ~np.isnan(self.points[:, 0]) | (self.vertices >= 0)
        return known

    def in_frame(self, frame: Frame) -> Landmarks:
        """The same landmarks in the other frame of anatomy: x and y change their sign.

        Raises
        ------
        ParameterError
            Landmarks that do not say which frame they are in.
        """
        if self.frame is None:
            raise ParameterError(f"these landmarks do not say whether they are RAS or LPS; they cannot become {frame}")
        if frame == self.frame:
            return self
        return Landmarks(self.names, self.points * [-1.0, -1.0, 1.0], self.vertices, frame)
