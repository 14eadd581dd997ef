"""A Bus Pirate kept in one mode with its settings: entered at set-up, entered again when it was lost.

Set-up raises PortError or BusPirateError. Later on nothing is raised: an exchange that fails is None, and
the next one that is due tries to open the port, enter the mode and set it up anew, at most every
`FIRST_PAUSE_S` … `LONGEST_PAUSE_S`. An attempt takes up to a second when something is there that does not
answer, and no time when the port is gone. Entering a mode switches the bridge's outputs and power off and
on again, so a chip that it feeds starts from its power-on state: the firmware's own check notices.
"""

from __future__ import annotations

import time
from dataclasses import dataclass

from serial import SerialException

from hal.live.bus_pirate import BusPirate, BusPirateError
from hal.live.port import PortError

FIRST_PAUSE_S = 0.05
LONGEST_PAUSE_S = 5.0
POWER_UP_S = 0.02
"""From the supply to the first access, for what hangs on the bridge."""


@dataclass
class BridgeCounters:
    """What has happened on a bridge since its set-up."""

    exchanges: int = 0
    failures: int = 0
    """Exchanges without a whole and sensible reply."""
    recoveries: int = 0
    last_problem: str = ""


class BridgeSession:
    """One Bus Pirate in one mode. `settings` are its commands of one byte, in order, power last."""

    def __init__(self, url: str, mode: int, name: bytes, settings: tuple[int, ...]) -> None:
        self.url = url
        self.counters = BridgeCounters()
        self._mode = mode
        self._name = name
        self._settings = list(settings)
        self._pause_s = FIRST_PAUSE_S
        self._try_after = 0.0
        self._pirate: BusPirate | None = BusPirate.open(url)
        self._in_step = False
        try:
            self._enter(self._pirate)
        except (OSError, SerialException) as error:
            self._pirate.close()
            raise BusPirateError(f"{url}: the port went away during set-up ({error})") from None
        except BusPirateError:
            self._pirate.close()
            raise

    @property
    def works(self) -> bool:
        """Whether the last exchange succeeded."""
        return self._in_step

    def exchange(self, request: bytes, bus_s: float) -> bytes | None:
        """A reply byte for each byte of `request`, or None."""
        self.counters.exchanges += 1
        pirate = self._pirate if self._in_step else self._recovered()
        if pirate is None:
            self.counters.failures += 1
            return None
        try:
            reply = pirate.exchange(request, bus_s)
        except (OSError, SerialException) as error:
            self._vanished(error)
            return None
        if len(reply) != len(request):
            self.out_of_step(f"{len(reply)} of {len(request)} bytes answered")
            return None
        return reply

    def out_of_step(self, problem: str) -> None:
        """The last reply made no sense: start anew before the next exchange."""
        self.counters.failures += 1
        self._give_up(problem)

    def set(self, command: int) -> bool:
        """Replace the setting of the same kind (upper four bits) by this one, now and for later."""
        kind = command & 0xF0
        self._settings = [command if one & 0xF0 == kind else one for one in self._settings]
        reply = self.exchange(bytes((command,)), 0.0)
        if reply is not None and reply != b"\x01":
            self.out_of_step(f"answers {reply.hex()} to the setting 0x{command:02X}")
        return self._in_step

    def setting(self, kind: int) -> int:
        """The setting whose upper four bits are `kind`."""
        return next(one for one in self._settings if one & 0xF0 == kind)

    def close(self) -> None:
        """Switch the outputs off and let go of the port."""
        pirate, self._pirate = self._pirate, None
        self._in_step = False
        self._try_after = float("inf")
        if pirate is not None:
            pirate.leave()

    def _enter(self, pirate: BusPirate) -> None:
        pirate.enter(self._mode, self._name)
        pirate.configure(*self._settings)
        time.sleep(POWER_UP_S)
        self._in_step = True

    def _recovered(self) -> BusPirate | None:
        """The bridge back in its mode, when an attempt is due and succeeds."""
        if time.monotonic() < self._try_after:
            return None
        try:
            if self._pirate is None:
                self._pirate = BusPirate.open(self.url)
            self._enter(self._pirate)
        except (PortError, BusPirateError) as error:
            self._postpone(str(error))
            return None
        except (OSError, SerialException) as error:
            self._close_port()
            self._postpone(str(error))
            return None
        self.counters.recoveries += 1
        self._pause_s = FIRST_PAUSE_S
        return self._pirate

    def _vanished(self, error: Exception) -> None:
        self.counters.failures += 1
        self._close_port()
        self._give_up(str(error))

    def _close_port(self) -> None:
        if self._pirate is not None:
            self._pirate.close()
            self._pirate = None

    def _give_up(self, problem: str) -> None:
        self._in_step = False
        self._pause_s = FIRST_PAUSE_S
        self._postpone(problem)

    def _postpone(self, problem: str) -> None:
        self.counters.last_problem = problem
        self._try_after = time.monotonic() + self._pause_s
        self._pause_s = min(2.0 * self._pause_s, LONGEST_PAUSE_S)
