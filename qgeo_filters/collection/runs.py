"""Computing what a collection does not have yet: shapes first, then pairs, by whichever engine."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial as applied
from typing import Any, TypeVar

from qgeo_filters.collection.engines import run_chunks
from qgeo_filters.collection.members import Problem, unique
from qgeo_filters.collection.pairs import Pairs, checked_part, chosen_pairs, chunks_of_pairs
from qgeo_filters.collection.stored_shapes import StoredShapes
from qgeo_filters.collection.tasks import Failure, pair_task, prepare_task

Own = TypeVar("Own", bound="Runs")


class Runs(StoredShapes):
    """Shapes that can be prepared and matched."""

    def prepare(
        self: Own,
        names: Sequence[str] | None = None,
        *,
        part: tuple[int, int] = (1, 1),
        workers: int | None = None,
        backend: str = "loky",
        scheduler: Any = None,
        progress: bool = False,
    ) -> Own:
        """Compute what belongs to single shapes, where it is not kept yet; parameters as in `match`."""
        k, n = checked_part(part)
        chosen = unique(self.names if names is None else names)
        self._failed = []
        missing = unique(
            self._entry(name).surface for name in chosen[k - 1 :: n] if not self.store.has(self._shape_place(name))
        )
        self._run(prepare_task, [[key] for key in missing], workers, backend, scheduler, progress, "shape")
        return self

    def match(
        self: Own,
        pairs: Pairs = None,
        *,
        part: tuple[int, int] = (1, 1),
        workers: int | None = None,
        backend: str = "loky",
        scheduler: Any = None,
        progress: bool = False,
    ) -> Own:
        """Match pairs of shapes, where that is not kept yet.

        Parameters
        ----------
        pairs : "all", "within groups", or iterable of (str, str), optional
            Each two shapes, the earlier one as X, by default; those of one group; or names of X and Y.
        part : (int, int)
            (3, 40): the third of forty parts of the work, for the job arrays of clusters. Parts share one store.
        workers : int, optional
            Processes, of one thread each; all cores by default. Results do not depend on it.
        backend : str
            Of joblib: "loky", "multiprocessing", "threading" or a registered one.
        scheduler : str or dask.distributed.Client, optional
            Dask cluster that takes the work; its workers must see the folder of the store.
        progress : bool
            Whether to show a bar with the time that is left.

        Returns
        -------
        Collection
            This one. Pairs that fail are in `problems`.

        Raises
        ------
        OSError
            The store cannot be written to: the disk is full, say. What was finished stays.
        WorkersLostError
            A worker process or the cluster went away. What was finished stays.
        """
        k, n = checked_part(part)
        # Parts are cut before it is known what is finished: they are the same for all processes.
        chunks = chunks_of_pairs(chosen_pairs(pairs, self.names, list(self.groups.values())))[k - 1 :: n]
        missing = [[pair for pair in chunk if not self.store.has(self._pair_place(*pair))] for chunk in chunks]
        involved = unique(name for chunk in missing for pair in chunk for name in pair)
        options: dict[str, Any] = {"workers": workers, "backend": backend, "scheduler": scheduler, "progress": progress}
        self.prepare(involved, **options)
        lost = {name for name in involved if self._problem_of(name)} | {one.subject for one in self._failed}
        left = [[pair for pair in chunk if not lost & set(pair)] for chunk in missing]
        keys = [[(self._entry(x).surface, self._entry(y).surface) for x, y in chunk] for chunk in left if chunk]
        self._run(pair_task, keys, workers, backend, scheduler, progress, "pair")
        return self

    def _run(
        self,
        task: Callable[..., list[Failure]],
        chunks: list[Any],
        workers: int | None,
        backend: str,
        scheduler: Any,
        progress: bool,
        unit: str,
    ) -> None:
        if not chunks:
            return
        job = applied(task, str(self.store.root.resolve()), self.settings)
        names = {entry.surface: entry.name for entry in reversed(self._entries.values())}
        options: dict[str, Any] = {"workers": workers, "backend": backend, "scheduler": scheduler, "progress": progress}
        failures: Iterator[Failure] = run_chunks(job, chunks, unit=unit, **options)
        for failure in failures:
            self._failed.append(Problem(" - ".join(names[key] for key in failure.keys), failure.reason))
