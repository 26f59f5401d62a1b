"""MATLAB files: the forms that people keep meshes in, against SciPy's reader, and what damaged ones say."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.io
from shapes import blob, grid

from qgeo_filters.errors import MeshError
from qgeo_filters.io.matlab import Value, variables
from qgeo_filters.surface import Surface

V, F = blob(1)
X, Y, Z = V.T[:, :, None]
AS_ROWS = {"VERT": V, "TRIV": F + 1.0}
SAMPLES = Path(scipy.io.__file__).parent / "matlab" / "tests" / "data"


def wrote(tmp_path: Path, content: Mapping[str, Any], **options: Any) -> Path:
    scipy.io.savemat(tmp_path / "a.mat", dict(content), **options)
    return tmp_path / "a.mat"


def struct_array(*elements: Mapping[str, Any]) -> np.ndarray:
    array = np.zeros((1, len(elements)), [(name, object) for name in elements[0]])
    for number, element in enumerate(elements):
        array[0, number] = tuple(element.values())
    return array


FORMS: dict[str, Mapping[str, Any]] = {
    "TOSCA": {"surface": {"X": X, "Y": Y, "Z": Z, "TRIV": F + 1.0}},
    "coordinates in rows": {"surface": {"X": X.T, "Y": Y.T, "Z": Z.T, "TRIV": F + 1.0}},
    "struct with VERT": {"shape": AS_ROWS},
    "variables": AS_ROWS,
    "whole numbers": {"VERT": V, "TRIV": (F + 1).astype(np.uint16)},
    "other names": {"mesh": {"vertices": V, "faces": F + 1.0}},
    "one letter": {"V": V, "F": F + 1.0},
    "columns": {"vertex": V.T, "face": F.T + 1.0},
    "faces in columns": {"vertex": V, "face": F.T + 1.0},
    "nested": {"S": {"surface": {"X": X, "Y": Y, "Z": Z, "TRIV": F + 1.0}, "evals": np.arange(5.0), "nv": 42.0}},
    "twice the same": {"S": {"surface": {**AS_ROWS, "X": X, "Y": Y, "Z": Z}}, "M": {"surface": AS_ROWS}},
    "the outer of two": {"M": {**AS_ROWS, "original": {"VERT": 2 * V, "TRIV": F + 1.0}}},
    "beside what is no mesh": {"F": np.eye(5), "note": "cat", "list": np.array([1, "a"], object), "N": AS_ROWS},
    "in a cell": {"shapes": np.array([AS_ROWS, "cat"], object)},
    "struct array of one": {"shapes": struct_array(AS_ROWS)},
}


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("compressed", [False, True], ids=["plain", "compressed"])
def test_forms_of_meshes(tmp_path: Path, form: str, compressed: bool) -> None:
    surface = Surface.read(wrote(tmp_path, FORMS[form], do_compression=compressed))
    np.testing.assert_array_equal(surface.vertices, V)
    np.testing.assert_array_equal(surface.faces, F)


def test_version_4(tmp_path: Path) -> None:
    surface = Surface.read(wrote(tmp_path, {"name": "cat", **AS_ROWS}, format="4"))
    np.testing.assert_array_equal(surface.vertices, V)
    np.testing.assert_array_equal(surface.faces, F)


def test_three_vertices_lie_as_the_faces_do(tmp_path: Path) -> None:
    """Three by three says nothing of which is which."""
    points = np.array([[0.0, 0, 1], [1, 0, 2], [0, 1, 4]])
    faces = np.array([[1.0, 2, 3], [3, 2, 1]])
    for vertex, face in ((points, faces), (points.T, faces.T)):
        surface = Surface.read(wrote(tmp_path, {"vertex": vertex, "face": face}))
        np.testing.assert_array_equal(surface.vertices, points)
        np.testing.assert_array_equal(surface.faces, faces - 1)


REFUSED: dict[str, tuple[Mapping[str, Any], str]] = {
    "two meshes": ({"X1": AS_ROWS, "X2": {"VERT": 2 * V, "TRIV": F + 1.0}}, "2 meshes found, such as X1 and X2; save"),
    "two in an array": (
        {"s": struct_array(AS_ROWS, {"VERT": 2 * V, "TRIV": F + 1.0})},
        r"2 meshes found, such as s\(1\) and s\(2\)",
    ),
    "from 0": ({"VERT": V, "TRIV": F * 1.0}, r"names vertex 0, but MATLAB counts from 1 \(5 such faces\)"),
    "halves": ({"VERT": V, "TRIV": F + 0.5}, r"TRIV\[0, 0\] is .*\.5, not a whole number \(240 such\)"),
    "nan": ({"VERT": V, "TRIV": np.where(F == 3, np.nan, F + 1)}, r"TRIV\[.* is nan, not a whole number"),
    "huge": ({"VERT": V, "TRIV": np.where(F == 3, 1e300, F + 1)}, r"is 1e\+300, not a whole number"),
    "quadrilaterals": (
        {"VERT": V, "TRIV": np.ones((5, 4))},
        r"TRIV has shape \(5, 4\), expected three columns or rows",
    ),
    "uneven": (
        {"X": X, "Y": Y, "Z": Z[:9], "TRIV": F + 1.0},
        "X, Y and Z have 42, 42 and 9 numbers, expected as many",
    ),
    "complex": ({"VERT": V + 1j, "TRIV": F + 1.0}, "vertices must be real numbers, got complex ones"),
    "text": ({"VERT": V, "TRIV": "abc"}, "no mesh with fields X, Y, Z, TRIV .* the file holds VERT, TRIV"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_is_no_mesh_says_why(tmp_path: Path, case: str) -> None:
    content, message = REFUSED[case]
    file = wrote(tmp_path, content)
    with pytest.raises(MeshError, match=message) as caught:
        Surface.read(file)
    assert str(caught.value).startswith(f"{file}: ")


# -- the variables themselves -------------------------------------------------------------------------


def equals(own: Value, by_scipy: Any) -> bool:
    """Whether a value is SciPy's, where it is one that is read."""
    if own is None:
        return True
    if by_scipy.dtype.names or by_scipy.dtype == object:
        elements = own if isinstance(own, list) else [own]
        others = by_scipy.ravel(order="F")
        if by_scipy.dtype.names is None:
            return len(elements) == len(others) and all(map(equals, elements, others))
        return len(elements) == len(others) and all(
            list(one) == list(by_scipy.dtype.names) and all(equals(one[name], other[name]) for name in one)
            for one, other in zip(elements, others, strict=True)
        )
    assert isinstance(own, np.ndarray)
    return own.size == by_scipy.size == 0 or (own.shape == by_scipy.shape and bool((own == by_scipy).all()))


@pytest.mark.parametrize(
    "file", sorted(SAMPLES.glob("*.mat")) or [None], ids=lambda file: getattr(file, "stem", "none")
)
@pytest.mark.filterwarnings("ignore")  # SciPy's, of duplicate names
def test_samples_of_many_versions_hold_what_scipy_finds(file: Path | None) -> None:
    if file is None:
        pytest.skip("SciPy is installed without its samples")
    try:
        expected = scipy.io.loadmat(file)
    except Exception:
        expected = None
    if expected is None:  # damaged on purpose: no crash
        try:
            variables(file.read_bytes())
        except MeshError:
            return
        return
    found = variables(file.read_bytes())
    for name in expected:
        if name.startswith("__") or file.stem in ("nasty_duplicate_fieldnames", "test_empty_struct"):
            continue
        assert equals(found[name], expected[name]), name


def element(kind: int, data: bytes) -> bytes:
    return struct.pack("<II", kind, len(data)) + data + bytes(-len(data) % 8)


def matrix(kind: int, shape: tuple[int, ...], *parts: bytes, name: bytes = b"a") -> bytes:
    head = element(6, struct.pack("<II", kind, 0)) + element(5, struct.pack(f"<{len(shape)}i", *shape))
    return element(14, head + element(1, name) + b"".join(parts))


def file_of(*elements: bytes) -> bytes:
    return b"MATLAB 5.0".ljust(124) + b"\x00\x01IM" + b"".join(elements)


DAMAGED: dict[str, tuple[bytes, str]] = {
    "empty": (b"", "it is empty"),
    "text": (b"%!PS hello, this is no table at all", "no header of one"),
    "cut short": (file_of(matrix(6, (1, 2), element(9, bytes(16))))[:-8], "bytes announced"),
    "no data": (file_of(matrix(6, (1, 2))), "it ends within a variable"),
    "fewer numbers": (file_of(matrix(6, (1, 2), element(9, bytes(8)))), "1 numbers, where 2 are announced"),
    "more than there can be": (
        file_of(matrix(6, (2**31 - 1, 2**31 - 1), element(9, bytes(8)))),
        "1 numbers, where 4611686014132420609 are announced",
    ),
    "negative": (file_of(matrix(6, (-1, -2), element(9, bytes(16)))), r"the dimensions \[-1, -2\]"),
    "half a number": (file_of(matrix(6, (1, 1), element(9, bytes(7)))), "7 bytes of numbers of 8 bytes each"),
    "no type": (file_of(matrix(6, (1, 1), element(99, bytes(8)))), "numbers of type 99"),
    "endless cells": (file_of(matrix(1, (2**31 - 1, 2**31 - 1))), "it ends within a variable"),
    "endless structs": (
        file_of(matrix(2, (2**31 - 1, 9), element(5, struct.pack("<i", 8)), element(1, b"x".ljust(8, b"\0")))),
        "it ends within a variable",
    ),
    "names of no length": (
        file_of(matrix(2, (1, 1), element(5, bytes(4)), element(1, b"xy"))),
        "2 bytes of field names, each of 0",
    ),
    "no cell": (file_of(matrix(1, (1, 1), element(9, bytes(8)))), "a field or cell of type 9"),
    "no deflation": (file_of(struct.pack("<II", 15, 8) + bytes(8)), "while decompressing"),
    "no variable": (file_of(element(9, bytes(8))), "a variable of type 9"),
    "short tag": (file_of(struct.pack("<HHI", 1, 5, 0)), "a short element of 5 bytes"),
    "version 4": (struct.pack("<5i", 0, 2**30, 2**30, 0, 2) + b"a\0" + bytes(64), "1073741824 x 1073741824 numbers"),
    "version 4 of no type": (struct.pack("<5i", 99, 1, 1, 0, 2) + b"a\0" + bytes(8), "a variable of type 99"),
    "half a header": (struct.pack("<5i", 0, 1, 1, 0, 2) + b"a\0" + bytes(15), "it ends within a header"),
}


@pytest.mark.parametrize("case", DAMAGED)
def test_damaged_files_are_refused_in_words(tmp_path: Path, case: str) -> None:
    content, message = DAMAGED[case]
    (tmp_path / "a.mat").write_bytes(content)
    with pytest.raises(MeshError, match=rf"a\.mat: not a readable MATLAB file \(.*{message}"):
        Surface.read(tmp_path / "a.mat")


def test_structs_in_structs_without_end() -> None:
    inner = matrix(6, (1, 1), element(9, bytes(8)))
    for _ in range(3000):
        inner = element(14, inner[8:])
        inner = matrix(1, (1, 1), inner)
        if len(inner) > 100_000:
            break
    with pytest.raises(MeshError, match="structs more than 32 deep"):
        variables(file_of(inner))


def test_what_is_unpacked_is_bounded() -> None:
    """Zeros deflate to a thousandth: a file of 80 kB must not take 80 MB."""
    zeros = zlib.compress(matrix(6, (1, 10_000_000), element(9, bytes(80_000_000))), 9)
    with pytest.raises(MeshError, match="unpacks to more than a hundred times its size"):
        variables(file_of(struct.pack("<II", 15, len(zeros)) + zeros))
    v, f = grid(60)  # a flat mesh deflates well, and is read
    packed = zlib.compress(matrix(6, (3, len(v)), element(9, v.tobytes()), name=b"VERT"), 9)
    found = variables(file_of(struct.pack("<II", 15, len(packed)) + packed))
    np.testing.assert_array_equal(found["VERT"], v.T)
    assert len(f) == 7200


def test_big_endian() -> None:
    head = struct.pack(">II2I", 6, 8, 6, 0) + struct.pack(">II2i", 5, 8, 1, 2) + struct.pack(">HH", 1, 1) + b"a\0\0\0"
    body = head + struct.pack(">II2d", 9, 16, 1.5, -2)
    content = b"MATLAB 5.0".ljust(124) + b"\x01\x00MI" + struct.pack(">II", 14, len(body)) + body
    np.testing.assert_array_equal(variables(content)["a"], [[1.5, -2]])
