"""What one navigation epoch costs in Python: world asked, solution, twelve sentences, line, two events.

The budget is 80 µs on the machine of the design trial; the test leaves room for slower and busy ones.
"""

import math
from time import perf_counter

from neo_m8n_rig import BenchWorld, VirtualTime

from boards.chips.neo_m8n import NeoM8n
from boards.chips.world import GnssEpoch, Satellite
from hal.emulated.virtual_time import SECOND

EPOCHS_A_RUN = 200


class ConstantWorld:
    """Always the same epoch: the world's own work is not the receiver's."""

    def __init__(self, epoch: GnssEpoch) -> None:
        self._epoch = epoch

    def epoch(self, time_ns: int) -> GnssEpoch:
        return self._epoch


class Nowhere:
    """A line without a wire."""

    def __init__(self) -> None:
        self.bytes = 0

    def send(self, data: bytes) -> int:
        self.bytes += len(data)
        return len(data)

    def set_baud(self, baud: int) -> None:
        pass


def microseconds_per_epoch() -> tuple[float, float]:
    """Best of several runs, and the bytes of an epoch, with 13 GPS and 10 GLONASS satellites."""
    satellites = tuple(
        Satellite(system, first + n, math.radians(5 + 5 * n), math.radians(25 * n), 20.3 + n, n > 2)
        for system, first, count in (("GPS", 1, 13), ("GLONASS", 65, 10))
        for n in range(count)
    )
    world = ConstantWorld(BenchWorld(satellites=satellites).now)
    time = VirtualTime()
    line = Nowhere()
    NeoM8n(time, world, line, start_state="hot")
    best = math.inf
    for run in range(8):
        before = line.bytes
        end = (3 + EPOCHS_A_RUN * (run + 1)) * SECOND
        start = perf_counter()
        while time.next_due <= end:
            time.run_next()
        best = min(best, (perf_counter() - start) / EPOCHS_A_RUN * 1e6)
        size = (line.bytes - before) / EPOCHS_A_RUN
    return best, size


def test_an_epoch_of_the_default_set_is_cheap() -> None:
    cost, size = microseconds_per_epoch()
    assert 600 < size < 800
    assert cost < 160.0


if __name__ == "__main__":
    print("{:.1f} µs and {:.0f} bytes an epoch".format(*microseconds_per_epoch()))
