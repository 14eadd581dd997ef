"""The one pin of test equipment: who is connected to it makes its rising edges known."""

from __future__ import annotations

from collections.abc import Callable

from hal.emulated.pins import Net


class LatchPin(dict[str, "Net | None"]):
    """The pin LATCH; `latch` is called at each rising edge."""

    def __init__(self, latch: Callable[[], None]) -> None:
        super().__init__(LATCH=None)
        self._latch = latch

    def __setitem__(self, pin: str, net: Net | None) -> None:
        super().__setitem__(pin, net)
        if net is not None:
            net.listen_edge(True, self._latch)
