"""Exit codes, and how an exception becomes one. A user's mistake never shows a traceback."""

from __future__ import annotations

import errno
import sys
import traceback
from collections.abc import Callable
from typing import Any

import typer

from host.record.errors import UserError

EXIT_MET = 0
EXIT_NOT_MET = 1
EXIT_BAD_INPUT = 2
EXIT_FAILED = 3
EXIT_INTERRUPTED = 130

UsageError: Any = typer.BadParameter.__base__
"""Of the command line framework, which some versions of typer bring with them."""
DISK_ERRORS = (errno.ENOSPC, errno.EDQUOT, errno.EROFS)
PATH_ERRORS = (errno.ENAMETOOLONG, errno.EACCES, errno.EPERM, errno.ELOOP)


INTERRUPTED = "interrupted; what was written so far is marked as incomplete"
NOTHING_WRITTEN = "interrupted; nothing was written"
CAMPAIGN_INTERRUPTED = "interrupted; finished runs are kept, the same command goes on with the others"


def guarded(command: Callable[[], int], interrupted: str = INTERRUPTED) -> None:
    """Run a command and end with its exit code; messages go to standard error."""
    try:
        code = command()
    except UserError as error:
        code = _told(str(error), EXIT_BAD_INPUT)
    except KeyboardInterrupt:
        code = _told(interrupted, EXIT_INTERRUPTED)
    except BrokenPipeError:  # whoever read our output has gone; the command line framework ends quietly
        raise
    except Exception as error:
        code = _described(error)
    raise typer.Exit(code)


def told_usage(error: Any) -> int:
    """One message for an option or argument that cannot be understood; help where nothing was asked for.

    Returns the exit code.
    """
    if type(error).__name__ == "NoArgsIsHelpError":
        error.show()
        return EXIT_BAD_INPUT
    command = error.ctx.command_path if error.ctx is not None else "navtwin"
    return _told(f"{error.format_message().rstrip('.')}; {command} --help tells more", EXIT_BAD_INPUT)


def whole_number(text: str | int) -> int:
    """The value of an option like --seed."""
    try:
        return int(text)
    except ValueError:
        raise typer.BadParameter(f"{text!r} is not a whole number; for example 1") from None


def _described(error: Exception) -> int:
    """Wrong descriptions and full disks are told in a line; all else is a defect and shows where."""
    from boards.validation import DescriptionError
    from host.sim.scenario.errors import ScenarioError

    if isinstance(error, DescriptionError | ScenarioError):
        return _told(str(error), EXIT_BAD_INPUT)
    if isinstance(error, OSError) and error.errno in DISK_ERRORS:
        place = f"{error.filename}: " if error.filename else ""
        return _told(f"{place}{error.strerror}; free some space or name another --out", EXIT_BAD_INPUT)
    if isinstance(error, OSError) and error.errno in PATH_ERRORS and error.filename:
        return _told(f"{error.filename}: {error.strerror}", EXIT_BAD_INPUT)
    traceback.print_exc()
    return _told("the run failed: the traceback above tells where, in firmware or navtwin", EXIT_FAILED)


def _told(message: str, code: int) -> int:
    print(f"navtwin: {message}", file=sys.stderr)
    return code
