"""Warns of an example of the gallery that takes too long; ``make docs`` lets no warning through."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

from sphinx.util import logging

import qgeo_filters

#: Processor seconds, of all threads and processes together: those of a clock depend on what else the machine does.
MOST_SECONDS = 20.0

_started = 0.0


def watch(gallery_conf: dict[str, Any], file: str | Path | None, when: str) -> None:
    """Start or end one example's time: Sphinx-Gallery calls it before and after each (``reset_modules``)."""
    global _started
    if when == "before":
        qgeo_filters.warmup()  # kernels are compiled once, and no example is to blame for it
        _started = _processor_seconds()
    else:
        judge(Path(str(file)).name, _processor_seconds() - _started)


def judge(name: str, seconds: float) -> None:
    """Warn of an example that took more than `MOST_SECONDS`, and say what any other took."""
    logger = logging.getLogger(__name__)
    if seconds > MOST_SECONDS:
        logger.warning("%s takes %.0f processor seconds, more than %.0f: a smaller mesh?", name, seconds, MOST_SECONDS)
    else:
        logger.info("%s: %.1f processor seconds", name, seconds)


def _processor_seconds() -> float:
    return sum(os.times()[:4])  # user and system, of this process and of those that it has waited for
