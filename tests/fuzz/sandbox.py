"""Inputs tried one after the other in a process of their own, with bounds of memory and time for each.

A reader that dies, hangs or asks for too much memory ends that process: the input is a finding, and another process
goes on after it. Processes are forked from a server that has everything loaded, in a few milliseconds.
"""

from __future__ import annotations

import contextlib
import functools
import logging
import multiprocessing
import os
import random
import re
import resource
import shutil
import signal
import sys
import tempfile
import time
import traceback
import warnings
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from multiprocessing import forkserver
from multiprocessing.connection import Connection
from pathlib import Path
from typing import TYPE_CHECKING
from unittest import mock

if TYPE_CHECKING:
    from fuzz.targets import Target

SECONDS = 3.0  # of CPU for one input of some kilobytes; those that are read take milliseconds
BYTES = 512 << 20  # beyond what the process has when it has read the good files
PATIENCE = 120.0  # seconds on the clock, for what waits instead of computing
BATCH = 500  # inputs in one process


@dataclass(frozen=True)
class Finding:
    """An input on which a reader failed.

    Attributes
    ----------
    target : str
    index : int
        Number of the input, see `files_of`.
    fault : str
        What happened, and where.
    """

    target: str
    index: int
    fault: str


def files_of(target: str, seed: int, index: int) -> tuple[dict[str, bytes], bool]:
    """Files of an input, the same for the same numbers, and whether it is to be repaired."""
    rng = random.Random(f"{seed}/{target}/{index}")
    return _target(target).input(rng), rng.random() < 0.3


def fuzzed(target: str, seed: int, indices: Sequence[int]) -> Iterator[Finding]:
    """Findings among the inputs of these numbers."""
    for start in range(0, len(indices), BATCH):
        batch = list(indices[start : start + BATCH])
        while batch:
            done, findings = _run(_inputs, target, seed, batch)
            yield from findings
            batch = batch[done:]


def faults_of(target: str, inputs: Sequence[Mapping[str, bytes]]) -> dict[int, str]:
    """What a reader does wrong, by the number of the input; each is read as it is and to be repaired."""
    given = [(files, repair) for files in inputs for repair in (False, True)]
    faults: dict[int, str] = {}
    start = 0
    while start < len(given):
        done, findings = _run(_given, target, given[start:], start)
        faults.update((finding.index // 2, finding.fault) for finding in findings)
        start += done
    return faults


def _run(work: object, target: str, *arguments: object) -> tuple[int, list[Finding]]:
    """Number of inputs that a process of its own dealt with, and the findings among them."""
    context = _context()
    receiver, sender = context.Pipe(duplex=False)
    process = context.Process(target=work, args=(sender, target, *arguments), daemon=True)
    process.start()
    sender.close()
    findings, done, index = [], 0, -1
    try:
        while receiver.poll(PATIENCE):
            kind, value = receiver.recv()
            if kind == "begin":
                index, done = value, done + 1
            elif kind == "fault":
                findings.append(Finding(target, index, value))
            else:
                index = -1
        findings.append(Finding(target, index, f"more than {PATIENCE:g} s without an end"))
        process.kill()
    except EOFError:
        process.join()
        if index >= 0:
            findings.append(Finding(target, index, _death(process.exitcode)))
        elif process.exitcode:
            raise RuntimeError(f"the process for {target} ended with {process.exitcode} outside of any input") from None
    finally:
        process.join()
    return done, findings


def _death(code: int | None) -> str:
    if code == -signal.SIGPROF:
        return f"more than {SECONDS:g} s of CPU"
    return f"killed by {signal.Signals(-code).name}" if code and code < 0 else f"left with exit code {code}"


@functools.cache
def _context() -> multiprocessing.context.ForkServerContext:
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(["fuzz.targets", "nibabel", "zarr"])
    # The server does not take over sys.path, and says nothing of a module that it does not find.
    with mock.patch.dict(os.environ, PYTHONPATH=os.pathsep.join(sys.path)):
        forkserver.ensure_running()
    return context


def _target(name: str) -> Target:
    from fuzz.targets import MISDEED, TARGETS  # in the server and its processes only

    return MISDEED if name == "misdeed" else TARGETS[name]


# -- inside of the process ----------------------------------------------------------------------------


def _inputs(connection: Connection, target: str, seed: int, indices: Sequence[int]) -> None:
    with _bounded(target) as folder:
        for index in indices:
            files, repair = files_of(target, seed, index)
            _tried(connection, target, index, files, repair, folder)
    connection.send(("end", None))


def _given(connection: Connection, target: str, inputs: Sequence[tuple[Mapping[str, bytes], bool]], first: int) -> None:
    with _bounded(target) as folder:
        for index, (files, repair) in enumerate(inputs, start=first):
            _tried(connection, target, index, files, repair, folder)
    connection.send(("end", None))


@contextlib.contextmanager
def _bounded(target: str) -> Iterator[Path]:
    """Folder for inputs, when all that the good files need is loaded and memory is bounded to little more."""
    from qgeo_filters.errors import QgeoError

    logging.disable(logging.WARNING)
    with tempfile.TemporaryDirectory(dir="/dev/shm" if os.path.isdir("/dev/shm") else None) as name:
        folder = Path(name)
        for number, files in enumerate(_target(target).seeds()):
            repairs = (False, True) if number == 0 else (True,)
            for repair in repairs:
                _laid(folder / "good", files)
                with contextlib.suppress(QgeoError):  # whether good files are read is another test's question
                    _target(target).read(folder / "good", repair)
        with open("/proc/self/statm") as status:
            pages = int(status.read().split()[0])
        bound = pages * resource.getpagesize() + BYTES
        resource.setrlimit(resource.RLIMIT_AS, (bound, bound))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        yield folder


def _tried(
    connection: Connection, target: str, index: int, files: Mapping[str, bytes], repair: bool, folder: Path
) -> None:
    place = folder / "input"
    _laid(place, files)
    connection.send(("begin", index))
    with tempfile.TemporaryFile() as printed:
        kept = os.dup(1), os.dup(2)
        os.dup2(printed.fileno(), 1)
        os.dup2(printed.fileno(), 2)
        signal.setitimer(signal.ITIMER_PROF, SECONDS)  # its signal ends the process, in whatever library it is
        try:
            fault = _fault(target, place, files, repair)
        finally:
            signal.setitimer(signal.ITIMER_PROF, 0)
            for stream in (sys.stdout, sys.stderr):
                stream.flush()
            os.dup2(kept[0], 1)
            os.dup2(kept[1], 2)
            os.close(kept[0])
            os.close(kept[1])
        printed.seek(0)
        words = printed.read(200)
    if fault is None and words:
        fault = f"printed {words!r}"
    if fault is not None:
        connection.send(("fault", fault))
    connection.send(("end", index))


def _fault(target: str, place: Path, files: Mapping[str, bytes], repair: bool) -> str | None:
    from qgeo_filters.errors import QgeoError

    names = [Path(name).name for name in files] + [Path(name).parts[0] for name in files]
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            _target(target).read(place, repair)
        except QgeoError as error:
            message = str(error)
            if not any(name in message for name in names):
                return f"the message names no file: {message[:200]}"
            if re.search(r"\s\(\)(?=$|[.:;])|:\s*$|\n", message) or len(message) > 1000:
                return f"the message has no reason, several lines or no end: {message[:300]!r}"
        except Exception as error:
            frames = traceback.extract_tb(error.__traceback__)
            own = [frame for frame in frames if "qgeo_filters" in frame.filename or "fuzz" in frame.filename]
            places = " ... ".join(f"{Path(f.filename).name}:{f.lineno} {f.name}" for f in (own[-1:] + frames[-1:]))
            return f"{type(error).__name__}: {str(error)[:120]} [{places}]"
    for warning in caught:
        own = warning.category is UserWarning and any(name in str(warning.message) for name in names)
        if not own and "the old name goes with the next release" not in str(warning.message):
            where = f"{Path(warning.filename).name}:{warning.lineno}"
            return f"warns: {warning.category.__name__}: {str(warning.message)[:120]} [{where}]"
    return None


def _laid(folder: Path, files: Mapping[str, bytes]) -> None:
    """The folder with these files alone."""
    if folder.exists():
        shutil.rmtree(folder)
    for name, content in files.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content)


def timed_indices(seconds: float) -> Iterator[list[int]]:
    """Batches of numbers until the time is over."""
    end, start, size = time.monotonic() + seconds, 0, 10
    while time.monotonic() < end:
        yield list(range(start, start + size))
        start, size = start + size, min(BATCH, 2 * size)
