"""A surface in motion: one set of triangles, positions at several times."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from qgeo_filters._typing import FloatArray
from qgeo_filters.atomic import atomic_write
from qgeo_filters.errors import MeshError, ParameterError, reason
from qgeo_filters.hosts.dispatch import as_surface
from qgeo_filters.html_repr import card, shown
from qgeo_filters.io.formats import path_in_errors
from qgeo_filters.io.number_files import saved_arrays
from qgeo_filters.surface import Surface
from qgeo_filters.validation import frozen, real_numbers

_ATTRIBUTE = "attribute_"


@dataclass(frozen=True, eq=False)
class Animation:
    """Positions of one surface at several times.

    Parameters
    ----------
    surface : Surface, or whatever `as_surface` takes
        Triangles and attributes; its own position is that at rest, and need be none of the frames.
    positions : array-like, shape (k, n, 3)
        Of its vertices in each of at least one frame.
    times : array-like, shape (k,), optional
        Growing, in any unit; 0, 1, 2 ... by default.
    notes : str or sequence of str
        What was repaired, taken for granted or is in doubt, a sentence each.

    Raises
    ------
    ParameterError
        Positions that do not fit the surface or are not finite, times that do not grow.

    Examples
    --------
    >>> x = qg.testing.sample_surface()
    >>> walk = qg.Animation(x, [x.vertices, x.vertices + 1, x.vertices + 3])
    >>> len(walk), walk[2], walk.at(1.5)[0] - x.vertices[0]
    (3, Surface(162 vertices, 320 faces), array([2., 2., 2.]))
    """

    surface: Surface
    positions: FloatArray
    times: FloatArray = field(default_factory=lambda: np.zeros(0))
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        surface = as_surface(self.surface)
        positions = real_numbers(self.positions, "positions")
        n = surface.n_vertices
        if positions.ndim != 3 or positions.shape[1:] != (n, 3) or not len(positions):
            raise ParameterError(f"positions must have shape (frames, {n}, 3), got {positions.shape}")
        lost = np.flatnonzero(~np.isfinite(positions).all(axis=(1, 2)))
        if lost.size:
            raise ParameterError(f"{lost.size} frame(s) with coordinates that are not finite, the first is {lost[0]}")
        times = real_numbers(self.times, "times")
        times = times if times.size else np.arange(float(len(positions)))
        if times.shape != (len(positions),) or not np.isfinite(times).all() or (np.diff(times) <= 0).any():
            raise ParameterError(f"times must be {len(positions)} growing numbers, one for each frame")
        object.__setattr__(self, "surface", surface)
        object.__setattr__(self, "positions", frozen(positions))
        object.__setattr__(self, "times", frozen(times))
        object.__setattr__(self, "notes", (self.notes,) if isinstance(self.notes, str) else tuple(self.notes))

    def __len__(self) -> int:
        return len(self.positions)

    def __getitem__(self, frame: int) -> Surface:
        """The surface in one frame, with its attributes; negative numbers count from the end."""
        if not isinstance(frame, (int, np.integer)):
            raise ParameterError(f"a frame is a whole number, got {frame!r}: positions has several")
        return self.surface.with_vertices(self.positions[frame])

    def __iter__(self) -> Iterator[Surface]:
        return (self[frame] for frame in range(len(self)))

    def at(self, time: float) -> FloatArray:
        """Positions (n, 3) at any time within, between two frames on straight lines."""
        if not isinstance(time, (int, float, np.number)) or not self.times[0] <= time <= self.times[-1]:
            raise ParameterError(f"time must be from {self.times[0]:g} to {self.times[-1]:g}, got {time!r}")
        after = max(1, min(int(np.searchsorted(self.times, time)), len(self) - 1)) if len(self) > 1 else 0
        if after == 0:
            return self.positions[0]
        part = (time - self.times[after - 1]) / (self.times[after] - self.times[after - 1])
        blended: FloatArray = (1 - part) * self.positions[after - 1] + part * self.positions[after]
        return blended

    def to_npz(self, path: str | PathLike[str]) -> None:
        """Write frames, times, notes and the surface with its attributes to an .npz file that `from_npz` reads.

        The arrays are ``positions``, ``times``, ``notes``, ``faces``, ``vertices`` (at rest) and ``attribute_NAME``.

        Raises
        ------
        ParameterError
            An attribute of Python objects.
        """
        surface = self.surface
        arrays: dict[str, Any] = {"positions": self.positions, "times": self.times, "notes": np.array(self.notes, str)}
        arrays |= {"vertices": surface.vertices, "faces": surface.faces}
        arrays |= {_ATTRIBUTE + name: values for name, values in surface.attributes.items()}
        objects = [name for name, values in arrays.items() if values.dtype.hasobject]
        if objects:
            raise ParameterError(f"{objects[0]} holds Python objects, which no .npz file holds safely: leave it out")
        with atomic_write(path) as file:
            np.savez_compressed(file, **arrays)

    @classmethod
    def from_npz(cls, path: str | PathLike[str]) -> Animation:
        """The animation that `to_npz` wrote.

        Raises
        ------
        MeshError
            A file that is none, or is damaged; the message starts with the path.
        """
        with path_in_errors(Path(path)):
            arrays = saved_arrays(Path(path))
            lacking = [name for name in ("positions", "times", "notes", "vertices", "faces") if name not in arrays]
            if lacking:
                raise MeshError(f"no animation that to_npz wrote: it has no {lacking[0]}")
            attributes = {
                name.removeprefix(_ATTRIBUTE): values for name, values in arrays.items() if name.startswith(_ATTRIBUTE)
            }
            try:
                surface = Surface(arrays["vertices"], arrays["faces"], attributes)
                return Animation(surface, arrays["positions"], arrays["times"], tuple(arrays["notes"].astype(str)))
            except (ParameterError, TypeError, ValueError) as error:
                raise MeshError(f"the animation is damaged ({reason(error)})") from error

    def __repr__(self) -> str:
        notes = f", {len(self.notes)} note(s)" if self.notes else ""
        return f"{type(self).__name__}({len(self)} frames of {self.surface.n_vertices} vertices{notes})"

    def _repr_html_(self) -> str:
        steps = np.linalg.norm(np.diff(self.positions, axis=0), axis=2).mean(axis=1) if len(self) > 2 else None
        facts = {
            "frames": len(self),
            "times": f"{shown(float(self.times[0]))} to {shown(float(self.times[-1]))}",
            "surface": repr(self.surface),
            "apart": getattr(self, "apart", None),
            "notes": list(self.notes) or None,
        }
        label = "mean way of a vertex from frame to frame"
        return card(type(self).__name__, facts, bars=None if steps is None else steps[:60], bars_label=label)
