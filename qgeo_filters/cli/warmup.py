"""``qgeo warmup``: compiles the kernels once, so that the first real call does not wait."""

from __future__ import annotations

from qgeo_filters.cli.options import Quiet


def warmup(quiet: Quiet = False) -> None:
    """Compile all kernels into the cache beside the package; later calls and processes find them there."""
    import time

    import typer

    from qgeo_filters import warmup as compile_kernels

    started = time.perf_counter()
    compile_kernels()
    if not quiet:
        typer.echo(f"kernels compiled in {time.perf_counter() - started:.1f} s")
