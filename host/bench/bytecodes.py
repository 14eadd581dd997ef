"""Byte codes that a tick of 10 ms takes, function by function: the same count however busy the machine is.

Traced, a run is a hundred times slower; what compiled kernels, NumPy and the interpreter's own C code do is
not seen. A byte code costs some 5 ns in code that runs every tick and twice that in code that runs ten times
a second, which the processor's caches have lost in between.
"""

from __future__ import annotations

import sys
from collections import Counter
from pathlib import Path
from types import CodeType, FrameType
from typing import Any

from hal.emulated.virtual_time import SECOND
from host.record.result import RunRequest
from host.run.session import open_session

FROM_S, TO_S = 80, 100
TICKS = (TO_S - FROM_S) * 100
ROOT = Path(__file__).parents[2]


def bytecodes_per_tick(board: str, scenario: str) -> dict[str, float]:
    """Byte codes a tick by function, the most first; scoring of the traced seconds included."""
    counts: Counter[CodeType] = Counter()

    def trace(frame: FrameType, event: str, _argument: Any) -> Any:
        frame.f_trace_opcodes, frame.f_trace_lines = True, False
        if event == "opcode":
            counts[frame.f_code] += 1
        return trace

    def begin() -> None:
        """Event: from here on the firmware's stack is traced; each greenlet has a tracer of its own."""
        sys.settrace(trace)
        frame: FrameType | None = sys._getframe()
        while frame is not None:
            frame.f_trace, frame.f_trace_opcodes = trace, True
            frame = frame.f_back

    with open_session(RunRequest(board, scenario, capture=False)) as session:
        session.run_until(FROM_S * SECOND)
        session.look()
        session.board.time.at(session.now_ns + 1, begin)
        session.run_until(TO_S * SECOND)
        sys.settrace(trace)
        session.look()
        sys.settrace(None)
    return {_name(code): count / TICKS for code, count in counts.most_common()}


def _name(code: CodeType) -> str:
    """`hal/emulated/cpu.py: EmulatedCpu.serve`."""
    path = Path(code.co_filename)
    place = path.relative_to(ROOT) if path.is_relative_to(ROOT) else Path(path.name)
    return f"{place}: {code.co_qualname}"
