"""Tasks of a collection: functions of a store and keys that leave their results there; done twice they change nothing.

They run in this process, in others, or on other machines that see the folder of the store.
"""

from __future__ import annotations

import gc
import logging
import threading
import time
from collections import OrderedDict
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from qgeo_filters.collection.pair_arrays import record_of_match
from qgeo_filters.collection.settings import Settings
from qgeo_filters.collection.store import Store, pair_place, shape_place
from qgeo_filters.errors import QgeoError, concerning, reason
from qgeo_filters.matching.correspondence import match
from qgeo_filters.matching.prepared_shape import PreparedShape
from qgeo_filters.matching.shape_arrays import arrays_of_shape, shape_of_arrays
from qgeo_filters.parallel import default_workers, single_threaded_blas

_log = logging.getLogger(__name__)

# Prepared shapes that a thread of a worker keeps: the target of its pairs, and a few that it met before.
_KEPT = 4

#: Name of the attribute that says why there is no result.
PROBLEM = "problem"


@dataclass(frozen=True)
class Failure:
    """A task that ended in an error which may not come again: nothing of it is kept.

    Attributes
    ----------
    keys : tuple of str
        Of the surface, or of both.
    reason : str
    """

    keys: tuple[str, ...]
    reason: str


class UnpreparedError(QgeoError):
    """A shape that cannot be prepared, so that no pair of it can be matched."""


class _Held(threading.local):
    """Prepared shapes of one thread, the last used ones: solvers that they keep are not for two threads at once."""

    def __init__(self) -> None:
        self.shapes: OrderedDict[tuple[str, str], PreparedShape] = OrderedDict()


_held = _Held()


def forget() -> None:
    """Let go of the prepared shapes that this thread keeps."""
    _held.shapes.clear()


def prepare_task(root: str, settings: Settings, surfaces: Sequence[str], workers: int | None = 1) -> list[Failure]:
    """Prepare shapes, by the keys of their surfaces, and keep them in the store.

    Parameters
    ----------
    root : str
        Folder of the store.
    settings : Settings
    surfaces : sequence of str
    workers : int, optional
        Threads.

    Raises
    ------
    OSError
        The store cannot be written to.
    ParameterError
        This process has another version of the package.
    """
    settings.check_code()
    store = Store(root, create=False)

    def one(keys: tuple[str, ...]) -> None:
        place = shape_place(settings.shape_key(keys[0]))
        if not store.has(place):
            _prepare(store, settings, keys[0])

    return _done(one, [(key,) for key in surfaces], workers)


def pair_task(
    root: str, settings: Settings, pairs: Sequence[tuple[str, str]], workers: int | None = 1
) -> list[Failure]:
    """Match pairs of shapes, by the keys of their surfaces, and keep the maps in the store.

    Pairs of one target should stand together. A shape that is not prepared yet is prepared.
    """
    settings.check_code()
    store = Store(root, create=False)

    def one(keys: tuple[str, ...]) -> None:
        x, y = keys
        place = pair_place(settings, settings.shape_key(x), settings.shape_key(y))
        if store.has(place):
            return
        shape_x, shape_y = (_prepared(store, settings, key) for key in (x, y))
        started = time.process_time()
        try:
            found = match(
                shape_x, shape_y, normalize=settings.normalize, partial=settings.partial, mirror=settings.mirror
            )
            record = record_of_match(found, shape_x, shape_y, time.process_time() - started)
        except QgeoError as error:  # of these two shapes: it would come again
            store.write(place, {}, {PROBLEM: reason(error)})
        else:
            store.write(place, record.arrays, record.values)

    return _done(one, pairs, workers)


def _done(
    task: Callable[[tuple[str, ...]], None], parts: Sequence[tuple[str, ...]], workers: int | None
) -> list[Failure]:
    """What failed; a disk that does not take results ends it."""
    failures = []
    with default_workers(workers), single_threaded_blas:
        for keys in parts:
            try:
                task(keys)
            except OSError:
                raise
            except UnpreparedError as error:
                failures.append(Failure(keys, reason(error)))
            except Exception as error:  # of any kind: a night's work must not end with one bad mesh
                _log.debug("%s failed", " - ".join(keys), exc_info=True)
                said = reason(error) if isinstance(error, (QgeoError, MemoryError)) else repr(error)
                failures.append(Failure(keys, said))
    return failures


def _prepare(store: Store, settings: Settings, surface: str) -> None:
    """Prepare a shape and keep it, or why it cannot be."""
    place = shape_place(settings.shape_key(surface))
    try:
        shape = PreparedShape(store.surface(surface), parameters=settings.parameters, repair=settings.repair)
        arrays, values = arrays_of_shape(shape)
    except QgeoError as error:
        store.write(place, {}, {PROBLEM: reason(error), "surface": surface})
        return
    del shape
    gc.collect()  # in this thread, to which its factorisations belong, not in one of Zarr's
    store.write(place, arrays, {**values, "surface": surface})


def _prepared(store: Store, settings: Settings, surface: str) -> PreparedShape:
    """A prepared shape as the store has it, so that results do not depend on which process prepared it."""
    shapes, key = _held.shapes, (str(store.root), settings.shape_key(surface))
    if key not in shapes:
        while len(shapes) >= _KEPT:
            shapes.popitem(last=False)
            gc.collect()  # in this thread, to which its factorisations belong, not in one of Zarr's
        shapes[key] = restored_shape(store, settings, surface)
    shapes.move_to_end(key)
    return shapes[key]


def restored_shape(store: Store, settings: Settings, surface: str) -> PreparedShape:
    """A prepared shape out of the store; prepared first where it is not there.

    Raises
    ------
    UnpreparedError
        It cannot be prepared: why.
    """
    place = shape_place(settings.shape_key(surface))
    record = store.read(place)
    if record is None:
        _prepare(store, settings, surface)
        record = store.read(place)
    if record is None:
        raise OSError(f"{store.root / place} cannot be read after it was written")
    if PROBLEM in record.values:
        raise UnpreparedError(record.values[PROBLEM])
    with concerning(str(store.root / place)):
        return shape_of_arrays(store.surface(surface), record.arrays, record.values, settings.parameters)
