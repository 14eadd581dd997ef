"""Any accesses in any order: nothing raises, and who follows the pins changes no answer."""

from __future__ import annotations

from typing import Any

import numpy as np
from adis16407_rig import G, Rig
from hypothesis import given, settings
from hypothesis import strategies as some

WRITES = some.tuples(
    some.just("write"), some.sampled_from([*range(0x1E, 0x44), *range(0x44, 0x50)]), some.integers(0, 255)
)
OTHERS = some.one_of(
    some.tuples(some.just("wait"), some.integers(0, 400_000_000), some.just(0)),
    some.tuples(some.just("burst"), some.just(0), some.just(0)),
    some.tuples(some.just("read"), some.integers(0, 0x5A), some.just(0)),
    some.tuples(some.sampled_from(["DIO3", "DIO4", "RST"]), some.booleans(), some.just(0)),
    some.tuples(some.just("power"), some.booleans(), some.just(0)),
    some.tuples(some.just("supply"), some.sampled_from([4.5, 5.0, 5.5]), some.just(0)),
)


@settings(max_examples=120, deadline=None)
@given(some.lists(some.one_of(WRITES, OTHERS), max_size=25))
def test_following_the_pins_changes_no_answer(steps: list[tuple[str, Any, int]]) -> None:
    """Lazy or not: every word is the same, and nothing raises."""

    def motion(t: Any) -> dict[str, Any]:
        return {"wx": 400.0 * np.sin(7.0 * t), "fx": 20.0 * G * np.sin(2.0 * t), "bx": np.sin(3.0 * t)}

    seen: list[list[Any]] = []
    for listen in ("", "DIO1 DIO2 DIO3 DIO4"):
        rig = Rig(motion, listen=listen)
        answers: list[Any] = []
        for step, value, data in steps:
            if step == "write":
                answers.append(rig.word(0x8000 | value << 8 | data))
            elif step == "read":
                answers.append(rig.read(value))
            elif step == "burst":
                answers.append(rig.burst())
            elif step == "wait":
                rig.wait(value)
            elif step == "power":
                rig.chip.power(value)
            elif step == "supply":
                rig.chip.supply_v = value
            else:
                rig.nets[step].set(value)
        seen.append([answers, [str(report) for report in rig.chip.reports]])
    assert seen[0] == seen[1]
