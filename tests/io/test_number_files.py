"""Tables of numbers from text and from NumPy's files: what is read, and what is refused in bounds."""

from __future__ import annotations

import warnings
import zipfile
from io import BytesIO
from pathlib import Path

import numpy as np
import pytest

from qgeo_filters.errors import MeshError
from qgeo_filters.io.number_files import number_table, saved_arrays, whole_numbers


def wrote(tmp_path: Path, name: str, content: bytes) -> Path:
    (tmp_path / name).write_bytes(content)
    return tmp_path / name


def npy(array: object, header: tuple[bytes, bytes] = (b"", b"")) -> bytes:
    """Content of an .npy file, with a part of its header replaced by one of equal length."""
    out = BytesIO()
    np.save(out, array)
    return out.getvalue().replace(*header)


def npz(members: dict[str, bytes], method: int = zipfile.ZIP_DEFLATED) -> bytes:
    out = BytesIO()
    with zipfile.ZipFile(out, "w", method) as archive:
        for name, content in members.items():
            archive.writestr(name, content)
    return out.getvalue()


@pytest.mark.parametrize("text", ["1 2\n3 4\n", "\ufeff1 2\r\n3 4", "# a\n1\t2 # b\n\n 3 4\n", "1e0 +2.\n3 4\n#"])
def test_tables_of_text(tmp_path: Path, text: str) -> None:
    np.testing.assert_array_equal(number_table(wrote(tmp_path, "a.txt", text.encode())), [[1, 2], [3, 4]])


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "a.txt is empty"),
        (b"# nothing\n\n", "a.txt is empty"),
        (b"1 2\n3\n", "a.txt is no table of numbers"),
        (b"one\n", "a.txt is no table of numbers"),
        (b"\xff\x00\x01", "a.txt is no table of numbers"),
    ],
)
@pytest.mark.filterwarnings("error")
def test_what_is_no_table(tmp_path: Path, content: bytes, message: str) -> None:
    with pytest.raises(MeshError, match=message):
        number_table(wrote(tmp_path, "a.txt", content))


@pytest.mark.parametrize("dtype", ["i1", "u8", "f2", "f8", ">i4"])
def test_whole_numbers_of_any_type(dtype: str) -> None:
    found = whole_numbers(np.array([[0, 3]], dtype), "x")
    assert found.dtype == np.int64
    np.testing.assert_array_equal(found, [[0, 3]])


@pytest.mark.parametrize("bad", [0.5, np.nan, np.inf, 1e300, 2.0**60])
@pytest.mark.filterwarnings("error")
def test_what_is_no_whole_number_is_named(bad: float) -> None:
    with pytest.raises(MeshError, match=r"x\[1, 0\] is .*, not a whole number \(2 such\)"):
        whole_numbers([[0, 1], [bad, bad]], "x")
    with pytest.raises(MeshError, match="x must be whole numbers, got bool"):
        whole_numbers([True], "x")


def test_arrays_as_numpy_saves_them(tmp_path: Path) -> None:
    arrays = {"a": np.arange(6).reshape(2, 3), "b": np.asfortranarray(np.eye(3)[:, :2]), "c": np.array("x"), "d": 2.5}
    for save in (np.savez, np.savez_compressed):
        save(tmp_path / "a.npz", **arrays)
        found = saved_arrays(tmp_path / "a.npz")
        assert found.keys() == arrays.keys()
        for name, array in arrays.items():
            np.testing.assert_array_equal(found[name], array)
            assert found[name].dtype == np.asarray(array).dtype
    np.testing.assert_array_equal(saved_arrays(wrote(tmp_path, "a.npy", npy(np.arange(3))))[""], [0, 1, 2])


REFUSED = {
    "nothing": (b"", "neither an .npz nor an .npy file"),
    "text": (b"hello", "neither an .npz nor an .npy file"),
    "half": (npz({"a.npy": npy(np.arange(99))})[:-40], "not a readable .npz file"),
    "checksum": (npz({"a.npy": npy(np.arange(200, 209))}, zipfile.ZIP_STORED).replace(b"\xcb", b"\xcc"), "Bad CRC-32"),
    "no array": (npz({"a.npy": b"hello"}), "a of a.npz has no header of an array"),
    "Python's objects": (npy(np.array([None, 1]))[:128], "holds Python objects, which are not read"),
    "30 GB": (
        npy(np.arange(12), (b"(12,), }      ", b"(4000000000,)}")),
        r"announces int64 numbers of shape \(4000000000,\), where 96 bytes follow",
    ),
    "negative": (npy(np.arange(12), (b"(12,)", b"(-1,)")), r"of shape \(-1,\)"),
    "no tuple": (npy(np.arange(12), (b"(12,)", b"'123'")), "no header of an array"),
    "no end": (npy(np.arange(12), (b"}", b"(")), "no header of an array"),
    "another packer": (npz({"a.npy": npy(np.arange(12))}, zipfile.ZIP_BZIP2), "packed by a method"),
    "1 to 1000": (npz({"a.npy": npy(np.zeros(12_000_000))}), "unpacks to more than a hundred times the file's size"),
}


@pytest.mark.parametrize("case", REFUSED)
@pytest.mark.filterwarnings("error")
def test_what_lies_is_refused(tmp_path: Path, case: str) -> None:
    content, message = REFUSED[case]
    with pytest.raises(MeshError, match=message) as caught:
        saved_arrays(wrote(tmp_path, "a.npz", content))
    assert "a.npz" in str(caught.value)


def test_no_words_of_the_parser_reach_the_terminal(tmp_path: Path) -> None:
    """Python warns of odd literals, NumPy of headers that Python 2 wrote: both are read past."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = saved_arrays(wrote(tmp_path, "a.npy", npy(np.arange(12), (b"(12,), ", b"(12L,),"))))
    np.testing.assert_array_equal(found[""], np.arange(12))
