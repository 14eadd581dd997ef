"""Claims between processes: several that need the same code compiled do each piece once.

A claim is a locked file beside what is made. The system lifts it when its process ends, however it ends.
"""

import contextlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

try:
    import fcntl
except ImportError:  # a system without them: every process does everything
    fcntl: Any = None  # type: ignore[no-redef]


@contextlib.contextmanager
def claim(path: Path, wait: bool = False) -> Iterator[bool]:
    """Whether this process has the piece of work called `path` to itself while the block runs.

    False when another process is at it; `wait` until that one has finished. True where nothing can be locked.
    """
    try:
        file = path.open("a") if fcntl is not None else None
    except OSError:
        file = None
    if file is None:
        yield True
        return
    with file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB))
        except BlockingIOError:
            yield False
        else:
            yield True
