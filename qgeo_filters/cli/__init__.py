"""The command line: ``qgeo COMMAND``. Numbers, arrays, the mesh, pictures and a report, from files to a folder."""

from __future__ import annotations

import io
import sys
from typing import Annotated

import typer

from qgeo_filters.cli.collection import app as collection
from qgeo_filters.cli.compatibility import compatibility
from qgeo_filters.cli.demo import demo
from qgeo_filters.cli.errors import OneLineErrors, OneLineWarnings
from qgeo_filters.cli.evaluate import evaluate
from qgeo_filters.cli.fetch import fetch
from qgeo_filters.cli.geodesics import distances, path
from qgeo_filters.cli.interpolate import interpolate
from qgeo_filters.cli.match import match
from qgeo_filters.cli.mesh import info
from qgeo_filters.cli.pipeline import run
from qgeo_filters.cli.spectral import spectrum
from qgeo_filters.cli.symmetry import symmetry
from qgeo_filters.cli.transfer import transfer
from qgeo_filters.cli.warmup import warmup

app = typer.Typer(
    cls=OneLineErrors,
    add_completion=False,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)


def _version(wanted: bool) -> None:
    if wanted:
        from qgeo_filters import __version__

        typer.echo(f"qgeo-filters {__version__}")
        raise typer.Exit


@app.callback(invoke_without_command=True)
def qgeo(
    context: typer.Context,
    version: Annotated[bool, typer.Option("--version", callback=_version, is_eager=True, help="Show it.")] = False,
    debug: Annotated[bool, typer.Option("--debug", help="Show the traceback of an error.")] = False,
) -> None:
    """Curvature-guided quasi-geodesics of triangle meshes, their spectrum and symmetry.

    Every command writes result.json (numbers and parameters), result.npz (arrays), the mesh as PLY with its
    attributes, coloured as in the pictures, PNG pictures and report.html into a folder of its own.

    What is expensive is kept for later commands on the same meshes, in the user's cache folder, up to 4 GiB
    (--no-cache, QGEO_CACHE_DIR).
    """
    if context.invoked_subcommand is None:
        typer.echo(context.get_help())


for command in (
    demo, info, distances, spectrum, symmetry, match, compatibility, transfer, interpolate, evaluate, fetch, path, run,
    warmup,
):  # fmt: skip
    app.command(cls=OneLineWarnings)(command)
app.add_typer(collection, name="collection")


def main() -> None:
    """Entry point of ``qgeo``: exit code 2 and a line for bad input, 1 and a traceback for a bug, 130 after Ctrl-C."""
    if isinstance(sys.stdout, io.TextIOWrapper):  # whatever the terminal's encoding lacks is shown as an escape
        sys.stdout.reconfigure(errors="backslashreplace")
    app(prog_name="qgeo")
