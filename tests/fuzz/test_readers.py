"""Every reader on thousands of changed files: each is read, or refused by an error of the package that names it.

``QGEO_FUZZ_SECONDS`` makes the run as long as one likes, per reader; ``QGEO_FUZZ_SEED`` takes other inputs.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path

import pytest

if sys.platform != "linux":
    pytest.skip("memory is bounded through Linux's /proc", allow_module_level=True)
pytest.importorskip("zarr")

from fuzz.sandbox import faults_of, fuzzed, timed_indices
from fuzz.targets import TARGETS

SEED = int(os.environ.get("QGEO_FUZZ_SEED", "0"))
SECONDS = float(os.environ.get("QGEO_FUZZ_SECONDS", "0"))
COUNT = 300  # of each reader in the gate
CORPUS = Path(__file__).parent / "corpus"


@pytest.mark.parametrize("target", TARGETS)
def test_good_files_are_read(target: str, tmp_path: Path) -> None:
    for number, files in enumerate(TARGETS[target].seeds()):
        for name, content in files.items():
            path = tmp_path / str(number) / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(content)
        assert TARGETS[target].read(tmp_path / str(number), True) is not None


@pytest.mark.parametrize("target", TARGETS)
def test_changed_files_are_read_or_refused(target: str) -> None:
    if not TARGETS[target].seeds():
        pytest.skip("the library that reads it is not installed")
    batches = timed_indices(SECONDS) if SECONDS else [range(COUNT // TARGETS[target].cost)]
    faults = [f"input {found.index}: {found.fault}" for batch in batches for found in fuzzed(target, SEED, batch)]
    assert not faults[:20], f"{len(faults)} faults; `python -m fuzz.run --seed {SEED} --keep DIR {target}` keeps them"


@pytest.mark.parametrize("target", sorted(path.name for path in CORPUS.iterdir()))
def test_what_once_failed_is_read_or_refused(target: str) -> None:
    """Found by long runs, on the readers of that time; each folder is an input, its name what was wrong."""
    folders = sorted((CORPUS / target).iterdir())
    inputs = [
        {path.relative_to(folder).as_posix(): path.read_bytes() for path in folder.rglob("*") if path.is_file()}
        for folder in folders
    ]
    assert inputs
    assert {folders[number].name: fault for number, fault in faults_of(target, inputs).items()} == {}


# -- what the sandbox itself sees ---------------------------------------------------------------------


@pytest.mark.parametrize(
    ("misdeed", "fault"),
    [
        ("crash", "killed by SIGABRT"),
        ("hang", "s of CPU"),
        ("devour", "MemoryError"),
        ("stumble", "KeyError: 'x'"),
        ("shout", "printed b'corrupted"),
    ],
)
def test_the_sandbox_survives_and_tells(misdeed: str, fault: str) -> None:
    assert fault in faults_of("misdeed", [{misdeed: b""}])[0]
