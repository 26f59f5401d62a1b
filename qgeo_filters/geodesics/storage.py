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

from qgeo_filters.errors import ParameterError, require_package
from qgeo_filters.geodesics.distance_solver import DistanceSolver
from qgeo_filters.geodesics.metric import IntrinsicMesh
from qgeo_filters.parallel import GROUP, run_tasks

_KEY = "qgeo_distance_matrix"


def stored_matrix(
    path: Path,
    mesh: IntrinsicMesh,
    make_solver: Callable[[], DistanceSolver],
    accuracy: float,
    workers: int | None,
    progress: bool,
) -> Any:
    """Complete distance matrix as a Zarr array at the path, begun or continued there.

    One chunk is one row: sources are taken in groups that lie together on the surface, whatever their
    numbers, and a chunk is written once, whole, and put in place by renaming. After its rows, a group is
    marked in the array's attributes; a kill costs the groups then at work, one a thread.
    """
    zarr = require_package("zarr", "zarr", "distance_matrix(out=...)")
    n = mesh.n_vertices
    mark = fingerprint(mesh, accuracy)
    array = _opened(zarr, path, n, mark) if path.exists() else _created(zarr, path, n, mark)
    state = dict(array.attrs[_KEY])
    groups = range(0, n, GROUP)
    done = np.unpackbits(np.frombuffer(bytes.fromhex(state["done"]), np.uint8), count=len(groups)).astype(bool)
    if done.all():
        return array
    for leftover in path.rglob("*.partial"):  # files that a killed process did not finish
        leftover.unlink(missing_ok=True)
    missing = int((~done).sum()) * GROUP * n * 4
    free = shutil.disk_usage(path).free
    if free < missing:
        raise OSError(errno.ENOSPC, f"{path} needs {missing / 1e9:.3g} GB more, the disk has {free / 1e9:.3g} GB free")
    solver = make_solver()
    order = solver.source_order

    def task(first: int) -> None:
        sources = order[first : first + GROUP]
        rows = np.empty((len(sources), n), np.float32)
        solver.distances_into(rows, np.arange(len(sources)), sources)
        for source, row in zip(sources.tolist(), rows, strict=True):
            write_chunk(path / "c" / str(source) / "0", row)

    def finished(first: int) -> None:
        done[first // GROUP] = True
        array.attrs[_KEY] = {**state, "done": np.packbits(done).tobytes().hex()}

    try:
        run_tasks(
            task,
            [g for g, ready in zip(groups, done, strict=True) if not ready],
            workers,
            progress,
            finished,
            int(done.sum()),
        )
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


def write_chunk(path: Path, row: np.ndarray) -> None:
    """Put one row in place as Zarr 3 lays it down: without a compressor, a chunk is its little-endian bytes.

    A twentieth of the time of an assignment to the array, which would be most of the whole.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    unfinished = path.with_suffix(".partial")
    unfinished.write_bytes(row.astype("<f4", copy=False).data)
    unfinished.replace(path)


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
    nothing = np.packbits(np.zeros(-(-n // GROUP), bool)).tobytes().hex()
    try:
        return zarr.create_array(
            store=str(path), shape=(n, n), chunks=(1, n), dtype="float32", compressors=None, fill_value=float("nan"),
            serializer={"name": "bytes", "configuration": {"endian": "little"}},
            chunk_key_encoding={"name": "default", "separator": "/"},
            attributes={_KEY: {"fingerprint": mark, "group": GROUP, "done": nothing}},
        )  # fmt: skip
    except OSError as error:
        raise OSError(error.errno, f"cannot write {path}: {error.strerror}") from error


def _opened(zarr: Any, path: Path, n: int, mark: str) -> Any:
    """Array begun by an earlier call for the same mesh, or `ParameterError`."""
    advice = "choose another path, or delete it"
    try:
        array = zarr.open_array(str(path), mode="r+")
    except Exception as error:
        raise ParameterError(f"{path} is there and is not a Zarr array; {advice}") from error
    if array.shape != (n, n) or array.dtype != np.float32:
        raise ParameterError(
            f"{path} holds a {array.dtype} array of shape {array.shape}, not float32 {(n, n)}; {advice}"
        )
    state = array.attrs.get(_KEY)
    if not isinstance(state, dict) or state.get("group") != GROUP:
        raise ParameterError(f"{path} was not written by this version of distance_matrix(out=...); {advice}")
    if state["fingerprint"] != mark:
        raise ParameterError(f"{path} holds the distances of another mesh, metric or accuracy; {advice}")
    if not os.access(path, os.W_OK | os.X_OK) and set(state["done"]) != {"f"}:
        raise PermissionError(f"cannot continue {path}: it is read-only")
    return array
