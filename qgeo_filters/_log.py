"""Logging under one name: ``logging.getLogger("qgeo_filters")``, silent until the user asks for it.

Each module logs under its own name, which is below that one. Debug: what took long, what the cache did. Info: what was
decided or changed for the user, such as a repair. Warning: what works, but should be mended.
"""

from __future__ import annotations

import logging
import time
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def timed(log: logging.Logger, message: str, *arguments: object) -> Iterator[None]:
    """Context whose seconds are logged at debug after the message, when it ends well."""
    started = time.perf_counter()
    yield
    log.debug(f"{message}: %.2f s", *arguments, time.perf_counter() - started)
