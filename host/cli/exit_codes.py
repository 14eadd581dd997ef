"""Exit codes, and how an exception becomes one. A user's mistake never shows a traceback."""

from __future__ import annotations

import errno
import sys
import traceback
from collections.abc import Callable

import typer

from host.record.errors import UserError

EXIT_MET = 0
EXIT_NOT_MET = 1
EXIT_BAD_INPUT = 2
EXIT_FAILED = 3
EXIT_INTERRUPTED = 130

DISK_ERRORS = (errno.ENOSPC, errno.EDQUOT, errno.EROFS)


def guarded(command: Callable[[], int]) -> None:
    """Run a command and end with its exit code; messages go to standard error."""
    try:
        code = command()
    except UserError as error:
        code = _told(str(error), EXIT_BAD_INPUT)
    except KeyboardInterrupt:
        code = _told("interrupted; what was written so far is marked as incomplete", EXIT_INTERRUPTED)
    except BrokenPipeError:  # whoever read our output has gone; the command line framework ends quietly
        raise
    except Exception as error:
        code = _described(error)
    raise typer.Exit(code)


def _described(error: Exception) -> int:
    """Wrong descriptions and full disks are told in a line; all else is a defect and shows where."""
    from boards.validation import DescriptionError
    from host.sim.scenario.errors import ScenarioError

    if isinstance(error, DescriptionError | ScenarioError):
        return _told(str(error), EXIT_BAD_INPUT)
    if isinstance(error, OSError) and error.errno in DISK_ERRORS:
        place = f"{error.filename}: " if error.filename else ""
        return _told(f"{place}{error.strerror}; free some space or name another --out", EXIT_BAD_INPUT)
    traceback.print_exc()
    return _told("the run failed: the traceback above tells where, in firmware or navtwin", EXIT_FAILED)


def _told(message: str, code: int) -> int:
    print(f"navtwin: {message}", file=sys.stderr)
    return code
