"""Errors of the package's own maps over the pairs of a data set, each pair kept as soon as it is finished."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
import numpy.typing as npt

from qgeo_filters._typing import IndexArray
from qgeo_filters.atomic import atomic_write
from qgeo_filters.errors import MeshError, ParameterError, QgeoError, reason
from qgeo_filters.evaluation.datasets import Dataset, NoTruthError, PointMap
from qgeo_filters.evaluation.errors import SymmetricErrors, geodesic_error
from qgeo_filters.evaluation.tables import PairResult
from qgeo_filters.fingerprint import content_key
from qgeo_filters.geodesics.matrix import distance_matrix
from qgeo_filters.io.number_files import saved_arrays
from qgeo_filters.matching.correspondence import match
from qgeo_filters.matching.prepared_shape import PreparedShape
from qgeo_filters.matching.symmetry import self_symmetry
from qgeo_filters.parallel import default_workers, worker_count
from qgeo_filters.surface import Surface

What = Literal["match", "symmetry"]

# Type and dimensions of what is kept of a pair.
_KINDS = {"key": ("U", 0), "direct": ("f", 1), "reflected": ("f", 1), "confident": ("b", 0), "seconds": ("f", 0)}
_KINDS |= {"p2p": ("i", 1), "mapped": ("f", 0), "coverage": ("f", 0), "handed": ("b", 0)}
# Beyond so many vertices all distances on Y would not fit, and those of the pairs of points are computed.
_MEASURED_BY_MATRIX = 12_000


@dataclass(frozen=True)
class _Job:
    what: What
    partial: bool


@dataclass(frozen=True)
class PairFailure:
    """A pair for which no error could be measured.

    Attributes
    ----------
    name, category : str
        As in `PairResult`.
    error : Exception
        What was raised.
    """

    name: str
    category: str
    error: Exception

    @property
    def reason(self) -> str:
        """The error in a line; with its type, where it is no fault of the data."""
        known = isinstance(self.error, (QgeoError, OSError, MemoryError))
        return reason(self.error) if known else repr(self.error)


class PairStore:
    """Finished pairs in a folder, one file for each, whole or not there.

    Parameters
    ----------
    folder : Path
        Made when the first pair is saved.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.reused = 0

    def load(self, name: str, category: str, key: str) -> PairResult | None:
        """The kept result, if it is that of the same shapes, truth and code.

        Raises
        ------
        ParameterError
            For a file of this name that is no result of a pair: it is somebody's, and is not replaced.
        """
        file = self._file(name)
        try:
            kept = saved_arrays(file)
        except FileNotFoundError:
            return None
        except MeshError as error:
            raise _foreign(file, reason(error)) from error
        kinds = {field: (array.dtype.kind, array.ndim) for field, array in kept.items()}
        odd = [field for field in sorted(kinds.keys() | _KINDS) if kinds.get(field) != _KINDS.get(field)]
        if file.is_symlink():
            raise _foreign(file, "a link")
        if odd:
            raise _foreign(file, f"{odd[0]} is not what it should be")
        if str(kept["key"]) != key:
            return None
        errors = SymmetricErrors(kept["direct"].astype(np.float64), kept["reflected"].astype(np.float64))
        if errors.direct.shape != errors.reflected.shape or not np.isfinite([errors.direct, errors.reflected]).all():
            raise _foreign(file, "errors that are no distances")
        self.reused += 1
        return PairResult(
            name,
            category,
            errors,
            bool(kept["confident"]),
            float(kept["seconds"]),
            kept["p2p"].astype(np.int64),
            mapped=float(kept["mapped"]),
            coverage=float(kept["coverage"]),
            handed=bool(kept["handed"]),
        )

    def save(self, result: PairResult, key: str) -> None:
        """Keep a result, in place of an earlier one of this name."""
        self.folder.mkdir(parents=True, exist_ok=True)
        with atomic_write(self._file(result.name)) as file:
            np.savez(
                file,
                key=key,
                direct=result.errors.direct,
                reflected=result.errors.reflected,
                confident=result.confident,
                seconds=result.seconds,
                p2p=result.p2p,
                mapped=np.float64(result.mapped),
                coverage=np.float64(result.coverage),
                handed=np.bool_(result.handed),
            )

    def _file(self, name: str) -> Path:
        return self.folder / f"{name.replace(' ', '')}.npz"


def measured(
    data: Dataset,
    pairs: Iterable[tuple[str, str]],
    what: What = "match",
    store: PairStore | None = None,
    *,
    partial: bool = False,
    workers: int | None = None,
) -> Iterator[PairResult | PairFailure]:
    """Errors of the map of each pair, one after the other; a pair that cannot be measured does not stop the rest.

    Parameters
    ----------
    data : Dataset
    pairs : iterable of (str, str)
        Names of shapes; for symmetries the same name twice. Each shape is prepared once, and kept (10 kB a vertex)
        until its last pair. Distances on Y, by which errors are measured, are kept from one pair to the next: pairs of
        one Y should stand together (`by_target`).
    what : {"match", "symmetry"}
        The correspondence from the first to the second, or the symmetry of the first (of the identity, where none is
        found).
    store : PairStore, optional
        Takes finished pairs, and gives those that it has.
    partial : bool
        Whether the first of each pair is a part of the second, of the same size.
    workers : int, optional
        Number of threads, at least 1; by default all cores that this process may use. Errors do not depend on it.

    Yields
    ------
    PairResult or PairFailure
        Seconds are CPU time without what belongs to one shape alone. Errors are those of points that were given an
        image.
    """
    count, job = worker_count(workers), _Job(what, partial)
    pairs = list(pairs)
    awaited = Counter(name for pair in pairs for name in pair)
    shapes: dict[str, PreparedShape] = {}
    ruler = Ruler()
    for x, y in pairs:
        name = f"{x} - {y}" if what == "match" else f"symmetry of {x}"
        outcome: PairResult | PairFailure
        try:
            for one in (x, y):
                if one not in shapes:
                    shapes[one] = PreparedShape(data.read(one))
            truth = data.truth(x, y) if what == "match" else data.symmetry(x)
            mirror = _mirror(data, x, y) if what == "match" else None
            key = _key(job, shapes[x], shapes[y], truth, mirror)
            kept = store.load(name, data.category(x), key) if store else None
            with default_workers(count):  # not around the yield: the caller's own work is not bounded
                outcome = kept or _measured(name, data.category(x), shapes[x], shapes[y], truth, mirror, job, ruler)
            if store and not kept:
                store.save(outcome, key)
        except Exception as error:  # of any kind: a night's work must not end with one bad mesh
            outcome = PairFailure(name, data.category(x), error)
        awaited.subtract((x, y))
        for one in {x, y}:
            if not awaited[one]:
                shapes.pop(one, None)
        yield outcome


def _foreign(file: Path, why: str) -> ParameterError:
    return ParameterError(f"{file} is not a result of an evaluation ({why}): move it away")


def by_target(pairs: Iterable[tuple[str, str]]) -> list[tuple[str, str]]:
    """The pairs with those of one target together, as `measured` likes them."""
    pairs = list(pairs)
    first: dict[str, int] = {}
    for place, (_, y) in enumerate(pairs):
        first.setdefault(y, place)
    return sorted(pairs, key=lambda pair: first[pair[1]])


class Ruler:
    """All distances on the surface that was asked for last."""

    def __init__(self) -> None:
        self._surface: Surface | None = None
        self._matrix: npt.NDArray[np.float32] = np.zeros((0, 0), np.float32)

    def __call__(self, surface: Surface) -> npt.NDArray[np.float32]:
        if self._surface is not surface:
            self._matrix = np.zeros((0, 0), np.float32)  # freed before the next one is made
            self._matrix, self._surface = distance_matrix(surface), surface
        return self._matrix


def _measured(
    name: str,
    category: str,
    x: PreparedShape,
    y: PreparedShape,
    truth: PointMap,
    mirror: IndexArray | None,
    job: _Job,
    ruler: Ruler,
) -> PairResult:
    if not job.partial:
        x.prepare()
        y.prepare()
    started = time.process_time()
    if job.what == "match":
        found = match(x, y, partial=job.partial, normalize=not job.partial)
        p2p, confident = found.p2p, found.confident
    else:
        symmetry = self_symmetry(x)
        p2p, confident = symmetry.nearest, symmetry.found
    seconds = time.process_time() - started
    target = y.full
    there = np.arange(y.given.n_vertices) if y.repair is None else y.repair.vertex_of_original
    place = np.where(p2p < 0, -1, there[p2p])  # distances are those on the surface that was matched
    image, true = place[truth.points], there[truth.images]
    reflected = true if mirror is None else np.where(there[mirror] < 0, true, there[mirror])
    known = true >= 0
    counted = known & (image >= 0)
    if not counted.any():
        raise MeshError(f"not one of the {known.sum()} points with a known image was given one")
    matrix = ruler(target) if target.n_vertices <= _MEASURED_BY_MATRIX else None
    direct, other = (geodesic_error(image[counted], one[counted], target, matrix=matrix) for one in (true, reflected))
    return PairResult(
        name,
        category,
        SymmetricErrors(direct, other),
        confident,
        seconds,
        p2p,
        mapped=float(counted.sum() / known.sum()),
        coverage=float(target.vertex_areas[np.unique(place[place >= 0])].sum() / target.area),
        handed=mirror is not None,
    )


def _mirror(data: Dataset, x: str, y: str) -> IndexArray | None:
    try:
        return data.reflected_images(x, y)
    except NoTruthError:
        return None


def _key(job: _Job, x: PreparedShape, y: PreparedShape, truth: PointMap, mirror: IndexArray | None) -> str:
    shapes = [array for shape in (x.given, y.given) for array in (shape.vertices, shape.faces)]
    return content_key(job.what, job.partial, shapes, [truth.points, truth.images], mirror)
