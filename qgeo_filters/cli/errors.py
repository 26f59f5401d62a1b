"""Errors on the command line: one clear line on stderr and an exit code, instead of a traceback."""

from __future__ import annotations

import errno
import os
import sys
import warnings
from collections.abc import Collection, Iterator
from contextlib import contextmanager
from typing import Any, NoReturn

import typer
from typer.core import TyperCommand, TyperGroup

from qgeo_filters.errors import QgeoError, TooLargeError, of_file, one_line, reason

BAD_INPUT = 2
INTERRUPTED = 130
# What the library's advice calls its arguments, and the command line its options.
_OPTIONS = {
    "repair=True": "--repair",
    "repair='force'": "--force-repair",
    "repair='wrap'": "--wrap",
    "normalize=True": "--normalize",
    "scans=True": "--scans",
    "baselines must": "--baselines must",
    "Look at it, ": "Look at it with qgeo match, ",
    "landmarks (correspondence=match(x, y, landmarks=...))": "landmarks with --hints",
    "accept_unsure=True": "--accept-unsure",
    "say which by specimen=": "say which by --specimen",
    "give the landmarks in the other of the frames RAS and LPS": "say the frame of the meshes by --frame RAS or LPS",
}

# What to do about errors of the disk, and about a lack of memory where the command has an option against it.
_NO_ROOM = "make room, or write elsewhere"
_ADVICE = {errno.ENOSPC: _NO_ROOM, errno.EDQUOT: _NO_ROOM, errno.EROFS: "write elsewhere"}
_SMALLER = {
    "matrix": "write the matrix to disk with --matrix FILE.zarr",
    "sources": "measure from few vertices with --sources",
    "landmarks": "let farthest points stand for all with --landmarks 1000",
}


class OneLineErrors(TyperGroup):
    """Group of commands whose errors are one line: bad input 2, Ctrl-C 130. ``--debug`` shows the traceback.

    Bad input is a `QgeoError`, or what the system says of a file. Another exception is a bug, and keeps its traceback.
    """

    def main(self, *args: Any, **extra: Any) -> Any:
        """Run a command and leave with its exit code."""
        try:
            code = super().main(*args, **{**extra, "standalone_mode": False})
        except Exception as error:
            # Typer's own errors. Their class depends on its version; that they format themselves does not.
            if not hasattr(error, "format_message"):
                raise
            context = getattr(error, "ctx", None)
            hint = f" (see {context.command_path} --help)" if context is not None else ""
            fail(f"{error.format_message().rstrip('.')}{hint}")
        try:
            with to_standard_output():
                sys.stdout.flush()
        except BrokenPipeError:
            sys.exit(1)
        except OSError as error:
            fail(_sentence(error))
        sys.exit(code if isinstance(code, int) else 0)

    def invoke(self, ctx: Any) -> Any:
        """Run a command; what it raises becomes a line."""
        try:
            return super().invoke(ctx)
        except KeyboardInterrupt:
            typer.echo("qgeo: interrupted; what was finished is kept", err=True)
            raise typer.Exit(INTERRUPTED) from None
        except BrokenPipeError:
            # The reader of our output went away (qgeo info mesh --json | head): nothing is left to say it to.
            _forget_output()
            raise typer.Exit(1) from None
        # Files, disks, networks and memory are the user's too. All else is a bug: its traceback is shown, exit code 1.
        except (QgeoError, OSError, MemoryError) as error:
            if ctx.params.get("debug"):
                raise
            if isinstance(error, MemoryError):
                fail(_too_large(error, [option.name for option in self.commands[ctx.invoked_subcommand].params]))
            fail(_sentence(error))


class OneLineWarnings(TyperCommand):
    """Command whose warnings are one line each, as its errors are; none with --quiet."""

    def invoke(self, ctx: Any) -> Any:
        """Run the command."""

        def show(message: Warning | str, *where: Any, **more: Any) -> None:
            if not ctx.params.get("quiet"):
                typer.echo(f"qgeo: warning: {in_options(one_line(str(message)))}", err=True)

        with warnings.catch_warnings():
            warnings.showwarning = show
            return super().invoke(ctx)


@contextmanager
def to_standard_output() -> Iterator[None]:
    """Context of printing results: an error names standard output."""
    try:
        with of_file("standard output"):
            yield
    except OSError:
        _forget_output()
        raise


def fail(message: str) -> NoReturn:
    """Leave with one line on stderr and the exit code of bad input."""
    typer.echo(f"qgeo: {one_line(message)}", err=True)
    sys.exit(BAD_INPUT)


def _sentence(error: BaseException) -> str:
    if isinstance(error, OSError) and error.strerror:
        if not error.filename:  # a sentence of ours, behind the system's number
            return error.strerror
        advice = _ADVICE.get(error.errno or 0)
        return f"{error.filename}: {error.strerror}" + (f": {advice}" if advice else "")
    return in_options(reason(error))


def in_options(message: str) -> str:
    """A message with options in place of the arguments that the library's advice names."""
    for argument, option in _OPTIONS.items():
        message = message.replace(argument, option)
    return message


def _too_large(error: MemoryError, options: Collection[str | None]) -> str:
    """What could not be had, and what takes less, given the names of the command's options."""
    said = one_line(str(error)).replace("Unable", "unable")
    if isinstance(error, TooLargeError):
        said = said.partition("; ")[0]  # what follows names arguments of functions
    ways = ["use a mesh of fewer vertices", *(way for name, way in _SMALLER.items() if name in options)]
    return f"not enough memory{f': {said}' if said else ''}; {', or '.join(ways)}"


def _forget_output() -> None:
    """Let go of what could not be printed, which Python would try once more at its end."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
