"""Landmarks from files and to files, by suffix.

=========================  ==================================================  ===============================
suffix                     read                                                written
=========================  ==================================================  ===============================
.csv, .tsv, .txt           columns name, x, y, z, vertex; or x y z             with a header, 17 digits
.fcsv                      Slicer's fiducials, of any version                  version 4.11
.mrk.json, .json           Slicer's Markups: points, lines, curves             one list of points
.tps                       LM3 and curves, times SCALE; several specimens      one specimen, no names
.pts                       Landmark Editor's, or rows of x y z                 Landmark Editor's
.landmarkAscii             Amira's and Avizo's, in ASCII                       one set, no names
.pp                        MeshLab's picked points                             the same
=========================  ==================================================  ===============================
"""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np

from qgeo_filters.atomic import atomic_write
from qgeo_filters.errors import MeshError, ParameterError
from qgeo_filters.io import landmark_tables, landmarks_meshlab, landmarks_morphometrics, landmarks_slicer
from qgeo_filters.io.formats import path_in_errors
from qgeo_filters.io.landmark_text import LandmarkSet
from qgeo_filters.io.landmarks import Frame, Landmarks

Reader = Callable[[Path], list[LandmarkSet]]
Writer = Callable[[Path, Landmarks], bytes]

_FORMATS: dict[str, tuple[Reader, Writer]] = {
    ".csv": (landmark_tables.read, landmark_tables.write),
    ".tsv": (landmark_tables.read, landmark_tables.write),
    ".txt": (landmark_tables.read, landmark_tables.write),
    ".fcsv": (landmarks_slicer.read_fcsv, landmarks_slicer.write_fcsv),
    ".json": (landmarks_slicer.read_markups, landmarks_slicer.write_markups),
    ".tps": (landmarks_morphometrics.read_tps, landmarks_morphometrics.write_tps),
    ".pts": (landmarks_morphometrics.read_pts, landmarks_morphometrics.write_pts),
    ".landmarkascii": (landmarks_morphometrics.read_landmark_ascii, landmarks_morphometrics.write_landmark_ascii),
    ".pp": (landmarks_meshlab.read_picked_points, landmarks_meshlab.write_picked_points),
}
_TABLES = (".csv", ".tsv", ".txt")  # hold vertices
_NAMELESS = (".tps", ".landmarkascii")


def read_landmarks(
    path: str | os.PathLike[str], *, specimen: str | int | None = None, frame: Frame | None = None
) -> Landmarks:
    r"""Landmarks from a file.

    Parameters
    ----------
    path : path
        The format is told by the suffix, see the table at the top of `io.landmark_files`.
    specimen : str or int, optional
        Which set of a file that holds several: its ID, image or name, or its number from 0.
    frame : {"RAS", "LPS"}, optional
        Frame in which the positions are wanted: those of a file in the other one have x and y negated. By default they
        come as they stand in the file, and ``landmarks.frame`` is what it says. Slicer saves meshes and landmarks in
        LPS since version 4.11; files of earlier ones, and those that say ``CoordinateSystem = 0``, are in RAS.

    Returns
    -------
    Landmarks
        Those that are missing (NA, undefined, not active) have positions of NaN.

    Raises
    ------
    FileNotFoundError, IsADirectoryError
    MeshError
        An unknown suffix, a malformed file; the message starts with the path and says in which line.
    ParameterError
        Several sets and no ``specimen``, none of that name; a ``frame`` for a file that does not say which it is in.

    Examples
    --------
    >>> import tempfile, pathlib
    >>> folder = tempfile.TemporaryDirectory()
    >>> path = pathlib.Path(folder.name) / "skull.csv"
    >>> _ = path.write_text("name,x,y,z\nnasion,0,1,2\nbregma,0,3,1\n")
    >>> marks = qg.read_landmarks(path)
    >>> marks, marks["bregma"]
    (Landmarks(2: nasion, bregma), array([0., 3., 1.]))
    >>> folder.cleanup()
    """
    file = Path(path)
    reader, _ = _format(file, "read")
    if not file.exists():
        raise FileNotFoundError(f"no such file: {file}")
    if file.is_dir():
        raise IsADirectoryError(f"{file} is a folder, not a file of landmarks")
    with path_in_errors(file):
        sets = reader(file)
    try:
        chosen = _chosen(sets, specimen).landmarks
        return chosen if frame is None else chosen.in_frame(frame)
    except ParameterError as error:
        raise ParameterError(f"{file}: {error}") from error


def write_landmarks(path: str | os.PathLike[str], landmarks: Landmarks) -> None:
    """Write landmarks to a file that is either whole or not there; the format is told by the suffix.

    Parameters
    ----------
    path : path
        See the table at the top of `io.landmark_files`.
    landmarks : Landmarks
        For Slicer those without a frame are called LPS, as it takes meshes to be.

    Warns
    -----
    UserWarning
        Where the format drops the names.

    Raises
    ------
    MeshError
        An unknown suffix.
    ParameterError
        Landmarks of which only vertices are known, for a format that holds positions.
    OSError
        Where the file cannot be written.

    Examples
    --------
    >>> import tempfile, pathlib
    >>> folder = tempfile.TemporaryDirectory()
    >>> path = pathlib.Path(folder.name) / "skull.fcsv"
    >>> qg.write_landmarks(path, qg.Landmarks(["nasion", "bregma"], [[0, 1, 2], [0, 3, 1]]))
    >>> qg.read_landmarks(path)
    Landmarks(2 in LPS: nasion, bregma)
    >>> folder.cleanup()
    """
    file = Path(path)
    content = landmarks_content(file, landmarks)
    names = tuple(str(i + 1) for i in range(len(landmarks)))
    if file.suffix.lower() in _NAMELESS and landmarks.names != names:
        warnings.warn(f"{file}: {file.suffix} holds no names, dropped: {', '.join(landmarks.names[:5])}", stacklevel=2)
    with atomic_write(file) as out:
        out.write(content)


def landmarks_content(name: str | os.PathLike[str], landmarks: Landmarks) -> bytes:
    """Content of a file of landmarks of this name, see `write_landmarks`."""
    file = Path(name)
    _, writer = _format(file, "written")
    suffix = file.suffix.lower()
    bare = np.flatnonzero(np.isnan(landmarks.points[:, 0]) & (landmarks.vertices >= 0))
    if bare.size and suffix not in _TABLES:
        raise ParameterError(
            f"{file}: {suffix} holds positions, but of landmark {bare[0]} ({landmarks.names[bare[0]]!r}) only the "
            f"vertex is known ({bare.size} such): write .csv, or give points=surface.vertices[landmarks.vertices]"
        )
    return writer(file, landmarks)


def _format(file: Path, what: str) -> tuple[Reader, Writer]:
    known = _FORMATS.get(file.suffix.lower())
    if known is None:
        raise MeshError(f"{file}: unknown suffix {file.suffix!r} of landmarks; {what} are {', '.join(_FORMATS)}")
    return known


def _chosen(sets: list[LandmarkSet], specimen: str | int | None) -> LandmarkSet:
    """The set that is asked for, or the only one."""
    listed = ", ".join(one.called[0] if one.called else str(i) for i, one in enumerate(sets[:8]))
    listed += ", ..." if len(sets) > 8 else ""
    if specimen is None:
        if len(sets) > 1:
            raise ParameterError(f"the file holds {len(sets)} sets of landmarks, say which by specimen=: {listed}")
        return sets[0]
    if isinstance(specimen, str):
        fitting = [one for one in sets if specimen in one.called]
        if len(fitting) != 1:
            raise ParameterError(
                f"{len(fitting) or 'no'} sets of landmarks are called {specimen!r}; there are {listed}"
            )
        return fitting[0]
    if isinstance(specimen, bool) or not 0 <= specimen < len(sets):
        raise ParameterError(f"specimen must be between 0 and {len(sets) - 1}, got {specimen!r}")
    return sets[specimen]
