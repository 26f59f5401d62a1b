"""Errors on the command line: one clear line on stderr and an exit code, instead of a traceback."""

from __future__ import annotations

import os
import sys
from typing import Any, NoReturn

import typer
from typer.core import TyperGroup

from qgeo_filters.errors import QgeoError

BAD_INPUT = 2
INTERRUPTED = 130
# The library's advice names its own arguments.
_OPTIONS = {"repair=True": "--repair", "repair='force'": "--force-repair", "normalize=True": "--normalize"}


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
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
            raise typer.Exit(1) from None
        # Files, disks and networks are the user's as well. All else is a bug: its traceback is shown, exit code 1.
        except (QgeoError, OSError) as error:
            if ctx.params.get("debug"):
                raise
            fail(_sentence(error))


def fail(message: str) -> NoReturn:
    """Leave with one line on stderr and the exit code of bad input."""
    line = " ".join(message.split())
    typer.echo(f"qgeo: {line}", err=True)
    sys.exit(BAD_INPUT)


def _sentence(error: BaseException) -> str:
    if isinstance(error, OSError) and error.strerror and error.filename:
        return f"{error.filename}: {error.strerror}"
    message = str(error)
    for argument, option in _OPTIONS.items():
        message = message.replace(argument, option)
    return message or type(error).__name__
