"""Fingerprints of what a result depends on: the content of its arguments and the code of this package."""

from __future__ import annotations

import functools
import hashlib
import sys
from pathlib import Path
from typing import Any

import joblib

# Folders that only show, measure or keep results (what is kept has a format of its own); all other code decides what
# comes out.
_SHOWING = ("cli", "report", "evaluation", "collection")


def numeric_sources() -> list[Path]:
    """Files of this package on which results depend."""
    root = Path(__file__).parent
    return sorted(file for file in root.rglob("*.py") if file.relative_to(root).parts[0] not in _SHOWING)


@functools.cache
def code_digest() -> str:
    """Fingerprint of the version and the numeric sources: results of other code are not taken for this one's."""
    digest = hashlib.sha256(str(getattr(sys.modules[__package__ or ""], "__version__", "")).encode())
    root = Path(__file__).parent
    for file in numeric_sources():
        content = file.read_bytes()
        digest.update(f"{file.relative_to(root).as_posix()} {len(content)}\n".encode())
        digest.update(content)
    return digest.hexdigest()


def content_key(stage: str, *parts: Any) -> str:
    """Key of a stage from the content of what it depends on (arrays, numbers, strings, None) and of this package."""
    return f"{stage}-{joblib.hash((stage, code_digest(), parts))}"
