"""The one way to compile a kernel: Numba's compiler, a cache on disk that knows all code, and a list of the kernels.

Numba's own cache looks at the file of the outermost function only: after an edit of a kernel, those that call it go on
running the old code. Here a compiled function is kept under a digest of its own code and of all that it calls, the
constants that it takes from its module among them, so that nothing has to be touched or cleared.
"""

from __future__ import annotations

import contextlib
import hashlib
import logging
import os
import pickle
import uuid
from collections.abc import Callable
from pathlib import Path
from types import CodeType, FunctionType, ModuleType
from typing import Any, TypeVar

import numba
import numpy as np
from numba.core.caching import FunctionCache
from numba.core.dispatcher import Dispatcher
from numba.core.serialize import dumps

_log = logging.getLogger(__name__)

F = TypeVar("F", bound=Callable[..., Any])

# Arguments that are typed: of a literal Numba would make a type of its own, and compile once more for it.
NONE: Any = np.int64(-1)
ZERO: Any = np.int64(0)

#: All kernels whose modules are loaded, by module and name.
KERNELS: dict[str, Dispatcher] = {}

_INNER: dict[str, Any] = {"error_model": "numpy", "no_cpython_wrapper": True, "no_cfunc_wrapper": True}


def njit(**options: Any) -> Callable[[F], F]:
    """Decorator: the function compiled on its first call, without the GIL, or loaded from the cache on disk.

    Parameters
    ----------
    options
        Those of `numba.njit`.
    """

    def decorate(function: F) -> F:
        dispatcher = numba.njit(nogil=True, **options)(function)
        if isinstance(dispatcher, Dispatcher):  # not where NUMBA_DISABLE_JIT is set
            try:
                dispatcher._cache = _Cache(dispatcher)  # type: ignore[attr-defined]
            except RuntimeError as error:  # Numba found no folder that it can write to
                _log.warning("kernels are compiled anew in every process, set NUMBA_CACHE_DIR to a folder: %s", error)
            KERNELS[f"{function.__module__}.{function.__qualname__}"] = dispatcher
        return dispatcher

    return decorate


def inner(function: F) -> F:
    """The function compiled, to be called from compiled functions only: that halves the time to compile it."""
    return njit(**_INNER)(function)


def kernel(function: F) -> F:
    """The function compiled as by `inner`, without reference counting of its arrays.

    A kernel works on the arrays that it is given and makes none. Counting references to them would be
    an atomic operation for each array in every call of a small function: measured, four fifths of the time
    of a window propagation. Who calls the outermost kernel holds the arrays.
    """
    return njit(**_INNER, _nrt=False)(function)


def code_digest(dispatcher: Dispatcher) -> str:
    """Digest of the code of a compiled function, its options, and of all functions and constants that it names."""
    digest = hashlib.sha256(numba.__version__.encode())
    _add_function(digest, dispatcher, set())
    return digest.hexdigest()[:16]


def _add_function(digest: Any, function: Any, seen: set[int]) -> None:
    if isinstance(function, Dispatcher):
        digest.update(repr(sorted(function.targetoptions.items())).encode())
        function = function.py_func
    if id(function) in seen:  # a function that calls itself
        return
    seen.add(id(function))
    digest.update(repr((function.__qualname__, function.__defaults__)).encode())
    _add_code(digest, function.__code__, function.__globals__, seen)
    for cell in function.__closure__ or ():
        _add_value(digest, cell.cell_contents, seen)


def _add_code(digest: Any, code: CodeType, names: dict[str, Any], seen: set[int]) -> None:
    digest.update(code.co_code)
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            _add_code(digest, constant, names, seen)
        else:
            digest.update(repr(constant).encode())
    for name in code.co_names:
        digest.update(name.encode())
        if name in names:
            _add_value(digest, names[name], seen)


def _add_value(digest: Any, value: Any, seen: set[int]) -> None:
    defined = getattr(value, "_defn", None)  # an intrinsic of Numba: what writes its instructions
    if isinstance(value, (Dispatcher, FunctionType)):
        _add_function(digest, value, seen)
    elif isinstance(defined, FunctionType):
        _add_function(digest, defined, seen)
    elif isinstance(value, ModuleType):
        digest.update(f"{value.__name__} {getattr(value, '__version__', '')}".encode())
    elif isinstance(value, np.ndarray):
        digest.update(repr((value.dtype, value.shape)).encode())
        digest.update(np.ascontiguousarray(value).tobytes())
    elif isinstance(value, type):
        digest.update(repr((value.__qualname__, getattr(value, "_fields", ()))).encode())
    elif isinstance(value, (bool, int, float, complex, str, bytes, tuple, np.generic, np.dtype)):
        digest.update(repr(value).encode())
    else:  # of no content that is known, such as a class of the compiler
        digest.update(type(value).__qualname__.encode())


class _Cache(FunctionCache):
    """Numba's cache of one function, beside its file or where Numba keeps those of read-only folders.

    Nothing is looked up in an index that several processes would have to write: each compiled version is one file, put
    in place whole, whose name is a digest of the code, the types of the arguments and the machine.
    """

    def __init__(self, dispatcher: Dispatcher) -> None:
        super().__init__(dispatcher.py_func)
        name = f"{Path(dispatcher.py_func.__code__.co_filename).stem}.{dispatcher.py_func.__qualname__}"
        self._cache_file: Any = _Files(Path(self.cache_path), name.replace("<", "").replace(">", ""), dispatcher)


class _Files:
    def __init__(self, folder: Path, name: str, dispatcher: Dispatcher) -> None:
        self.folder, self.name, self.dispatcher = folder, name, dispatcher
        self._code = ""

    @property
    def code(self) -> str:
        """Digest of the code, taken at the first call, when all modules are complete."""
        self._code = self._code or code_digest(self.dispatcher)
        return self._code

    def path(self, key: Any) -> Path:
        """File of the version for these types and this machine."""
        return self.folder / f"{self.name}-{self.code}-{hashlib.sha256(repr(key).encode()).hexdigest()[:16]}.nbc"

    def load(self, key: Any) -> Any:
        """Compiled version, None if there is none."""
        try:
            stored, data = pickle.loads(self.path(key).read_bytes())
        except FileNotFoundError:
            return None
        return data if stored == key else None

    def save(self, key: Any, data: Any) -> None:
        """Keep a compiled version, and let go those of other code."""
        path = self.path(key)
        partial = path.with_name(f"{path.name}.{uuid.uuid4().hex[:16]}.tmp")
        try:
            partial.write_bytes(dumps((key, data)))
            os.replace(partial, path)
        finally:
            partial.unlink(missing_ok=True)
        for old in self.folder.glob(f"{self.name}-*.nb[ci]"):
            if not old.name.startswith(f"{self.name}-{self.code}-"):
                with contextlib.suppress(OSError):  # another process was quicker, or runs it on Windows
                    old.unlink()

    def flush(self) -> None:
        """Let go of every version."""
        for old in self.folder.glob(f"{self.name}-*.nb[ci]"):
            old.unlink(missing_ok=True)
