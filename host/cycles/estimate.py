"""The estimate: what the runs of a counted kernel have cost."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import groupby
from typing import Any

from host.cycles.counted_code import CountedKernel
from host.cycles.prices import KINDS, Pricing
from host.cycles.whole_code import whole_code


@dataclass(frozen=True, slots=True)
class Cycles:
    """Of a number of calls together."""

    calls: int
    by_kind: dict[str, float]

    @property
    def per_call(self) -> float:
        """Mean of a call, with the call itself in it."""
        return sum(self.by_kind.values()) / self.calls if self.calls else 0.0


class PricedKernel:
    """A kernel that adds up what its calls cost."""

    def __init__(self, module: str, kernel: str) -> None:
        """`module` as for `whole_code`."""
        self._kernel = CountedKernel(whole_code(module, kernel))
        self._prices = [_prices_of(blocks) for blocks in _by_function(self._kernel)]
        self._calls = 0

    def __call__(self, *arguments: Any) -> Any:
        """Call it; see `CountedKernel`."""
        self._calls += 1
        return self._kernel(*arguments)

    def cycles(self) -> Cycles:
        """Of all calls so far."""
        by_kind = dict.fromkeys(KINDS, 0.0)
        prices = [price for function in self._prices for price in function]
        for count, block in zip(self._kernel.counts(), prices, strict=True):
            for kind, cycles in block.items():
                by_kind[kind] += count * cycles
        return Cycles(self._calls, by_kind)


def _by_function(kernel: CountedKernel) -> list[list[list[str]]]:
    groups = groupby(kernel.blocks, key=lambda block: block.function)
    return [[block.instructions for block in blocks] for _, blocks in groups]


def _prices_of(blocks: list[list[str]]) -> list[dict[str, float]]:
    pricing = Pricing([instruction for block in blocks for instruction in block])
    prices = []
    for block in blocks:
        sums: dict[str, float] = {}
        for instruction in block:
            price = pricing.price(instruction)
            if price.cycles:
                sums[price.kind] = sums.get(price.kind, 0.0) + price.cycles
        prices.append(sums)
    return prices
