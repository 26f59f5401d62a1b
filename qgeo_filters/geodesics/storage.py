"""The distance matrix on disk: a Zarr array that grows row by row and survives being killed."""

from __future__ import annotations

import errno
import hashlib
import os
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from qgeo_filters.errors import ParameterError, require_package
from qgeo_filters.geodesics.distance_solver import DistanceSolver
from qgeo_filters.geodesics.metric import IntrinsicMesh
from qgeo_filters.parallel import GROUP, run_tasks

_KEY = "qgeo_distance_matrix"

#: Takes the groups that are missing, and what is to be called with each that is done.
Runner = Callable[[list[int], Callable[[int], None]], None]


def stored_matrix(
    path: Path,
    mesh: IntrinsicMesh,
    make_solver: Callable[[], DistanceSolver],
    accuracy: float,
    workers: int | None,
    progress: bool,
    run: Runner | None = None,
) -> Any:
    """Complete distance matrix as a Zarr array at the path, begun or continued there.

    One chunk is one row: sources are taken in groups that lie together on the surface, whatever their
    numbers, and a chunk is written once, whole, and put in place by renaming. After its rows, a group is
    marked in the array's attributes; a kill costs the groups then at work, one a thread. ``run`` has `write_rows`
    called for each group by others: processes, a cluster.
    """
    zarr = require_package("zarr", "zarr", "distance_matrix(out=...)")
    n = mesh.n_vertices
    mark = fingerprint(mesh, accuracy)
    array = _opened(zarr, path, n, mark) if path.exists() else _created(zarr, path, n, mark)
    state = dict(array.attrs[_KEY])
    groups = range(0, n, GROUP)
    done = _marked(state["done"], len(groups))
    whole = np.array([_is_whole(_row(path, source), n) for source in range(n)])
    if done.all() and whole.all():
        return array
    solver = make_solver()
    order = solver.source_order
    # A row that was lost or cut short after its group was marked is computed again.
    done &= np.array([whole[order[first : first + GROUP]].all() for first in groups])
    for leftover in path.rglob("*.partial"):  # files that a killed process did not finish
        leftover.unlink(missing_ok=True)
    missing = int((~done).sum()) * GROUP * n * 4
    free = shutil.disk_usage(path).free
    if free < missing:
        raise OSError(errno.ENOSPC, f"{path} needs {missing / 1e9:.3g} GB more, the disk has {free / 1e9:.3g} GB free")

    def finished(first: int) -> None:
        done[first // GROUP] = True
        array.attrs[_KEY] = {**state, "done": np.packbits(done).tobytes().hex()}

    left = [first for first, ready in zip(groups, done, strict=True) if not ready]
    try:
        if run is not None:
            run(left, finished)
        else:
            run_tasks(lambda first: write_rows(path, solver, first), left, workers, progress, finished, int(done.sum()))
    except OSError as error:
        share = f"{int(done.sum())} of {len(groups)} groups of rows are written"
        if error.errno in (errno.ENOSPC, errno.EDQUOT):
            raise OSError(
                error.errno, f"the disk is full: {share} to {path}; make room and call again to continue"
            ) from error
        raise OSError(
            error.errno, f"cannot write {path} ({error.strerror}): {share}; call again to continue"
        ) from error
    return array


def write_rows(path: Path, solver: DistanceSolver, first: int) -> None:
    """Compute the rows of a group of sources, from this place on in the solver's order, and put them in place."""
    sources = solver.source_order[first : first + GROUP]
    rows = np.empty((len(sources), len(solver.source_order)), np.float32)
    solver.distances_into(rows, np.arange(len(sources)), sources)
    for source, row in zip(sources.tolist(), rows, strict=True):
        write_chunk(_row(path, source), row)


def write_chunk(path: Path, row: np.ndarray) -> None:
    """Put one row in place as Zarr 3 lays it down: without a compressor, a chunk is its little-endian bytes.

    A twentieth of the time of an assignment to the array, which would be most of the whole.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    unfinished = path.with_suffix(".partial")
    unfinished.write_bytes(row.astype("<f4", copy=False).data)
    unfinished.replace(path)


def _row(path: Path, source: int) -> Path:
    return path / "c" / str(source) / "0"


def _is_whole(row: Path, n: int) -> bool:
    """Whether a row is there and of the right length: Zarr takes one that is missing for NaN."""
    try:
        return row.stat().st_size == 4 * n
    except OSError:
        return False


def _marked(text: str, count: int) -> npt.NDArray[np.bool_]:
    """Which groups are done, from the hexadecimal digits in which it is kept."""
    return np.unpackbits(np.frombuffer(bytes.fromhex(text), np.uint8), count=count).astype(bool)


def fingerprint(mesh: IntrinsicMesh, accuracy: float) -> str:
    """Digest of all that the matrix depends on: triangles, side lengths and accuracy."""
    digest = hashlib.sha256(f"{mesh.n_vertices} {accuracy!r}".encode())
    digest.update(np.ascontiguousarray(mesh.faces).data)
    digest.update(np.ascontiguousarray(mesh.lengths).data)
    return digest.hexdigest()


def _created(zarr: Any, path: Path, n: int, mark: str) -> Any:
    """Array with no row written: NaN throughout."""
    folder = path.parent
    if not folder.is_dir():
        raise FileNotFoundError(f"cannot write {path}: {folder} is not a folder")
    if not os.access(folder, os.W_OK | os.X_OK):
        raise PermissionError(f"cannot write {path}: the folder {folder} is read-only")
    try:
        return _described(zarr, str(path), n, mark)
    except OSError as error:
        raise OSError(error.errno, f"cannot write {path}: {error.strerror}") from error


def _described(zarr: Any, store: Any, n: int, mark: str) -> Any:
    """New array in a store as this module writes its rows."""
    nothing = np.packbits(np.zeros(-(-n // GROUP), bool)).tobytes().hex()
    return zarr.create_array(
        store=store, shape=(n, n), chunks=(1, n), dtype="float32", compressors=None, fill_value=float("nan"),
        serializer={"name": "bytes", "configuration": {"endian": "little"}},
        chunk_key_encoding={"name": "default", "separator": "/"},
        attributes={_KEY: {"fingerprint": mark, "group": GROUP, "done": nothing}},
    )  # fmt: skip


def _opened(zarr: Any, path: Path, n: int, mark: str) -> Any:
    """Array begun by an earlier call for the same mesh, or `ParameterError`."""
    advice = "choose another path, or delete it"
    try:
        array = zarr.open_array(str(path), mode="r+")
        state = array.attrs.get(_KEY)
    except Exception as error:
        raise ParameterError(f"{path} is there and is not a Zarr array; {advice}") from error
    if array.shape != (n, n) or array.dtype != np.float32:
        raise ParameterError(
            f"{path} holds a {array.dtype} array of shape {array.shape}, not float32 {(n, n)}; {advice}"
        )
    fresh = _described(zarr, {}, n, mark)
    if not isinstance(state, dict) or not _fits(array, fresh) or not _state_fits(state, fresh.attrs[_KEY]):
        raise ParameterError(f"{path} was not written by this version of distance_matrix(out=...); {advice}")
    if state["fingerprint"] != mark:
        raise ParameterError(f"{path} holds the distances of another mesh, metric or accuracy; {advice}")
    if not os.access(path, os.W_OK | os.X_OK) and set(state["done"]) != {"f"}:
        raise PermissionError(f"cannot continue {path}: it is read-only")
    return array


def _fits(array: Any, fresh: Any) -> bool:
    """Whether an array is laid down as a new one would be: rows are written past Zarr, which then reads them."""
    found, expected = ({**one.metadata.to_dict(), "attributes": None} for one in (array, fresh))
    return repr(found) == repr(expected)  # NaN, the fill value, is equal to itself


def _state_fits(state: dict[str, Any], fresh: dict[str, Any]) -> bool:
    """Whether what is kept of the work's progress can be read as that of a new array."""
    return (
        state.keys() == fresh.keys()
        and state["group"] == fresh["group"]
        and isinstance(state["done"], str)
        and len(state["done"]) == len(fresh["done"])
        and set(state["done"]) <= set("0123456789abcdef")
    )
