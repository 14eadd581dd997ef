"""CAN bus on virtual time.

All that is queued is planned ahead: who wins the arbitration when, frame behind frame with three bits
between. What nobody has to know at once is told when the plan ends, with its exact instants, so that a set
of frames queued in one call costs one event; a node with an interrupt line hears of each frame at its end.
Where only late listeners hear, a set on an idle bus costs no event at all (`can_bursts`).

Errors (fact sheet, section 4): a frame that nobody acknowledges ends after its acknowledge slot in an error
frame and is sent again, for ever; the transmit error counter stops at error-passive, as the specification
has it for a node alone on its bus. A disturbed bus makes every attempt fail after the arbitration field:
+8 each time, bus-off beyond 255, back after 128 · 11 quiet bits. A success counts −1.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, NamedTuple

from hal.can import CanFrame
from hal.emulated.alarm import Alarm
from hal.emulated.can_bursts import MOST_KEPT, CanBursts, LateCanListener, heard_sets
from hal.emulated.can_frame import INTERFRAME_BITS, arbitration_key, frame_bits
from hal.emulated.virtual_time import FAR, SECOND, VirtualTime

if TYPE_CHECKING:
    from hal.emulated.can import CanNode

ACTIVE_FLAG_BITS = 6
ECHO_BITS = 6
DELIMITER_BITS = 8
SUSPEND_BITS = 8
RECOVERY_BITS = 128 * 11
ERROR_PASSIVE = 128
BUS_OFF = 256

CanListener = Callable[[CanFrame, int], None]
"""(frame, end_ns)."""


class Transmission(NamedTuple):
    """A planned frame or an attempt that fails. `length`: of the frame, `bits`: up to the next start."""

    begin: int
    end: int
    node: CanNode
    frame: CanFrame
    length: int
    bits: int
    succeeds: bool


class EmulatedCanBus:
    """The pair of wires."""

    def __init__(self, time: VirtualTime, bitrate: int, name: str = "can") -> None:
        if not 0 < bitrate <= 1_000_000:
            raise ValueError(f"CAN bit rate {bitrate} of {name!r}; classic CAN has at most 1_000_000")
        self.time = time
        self.bitrate = bitrate
        self.name = name
        self.error_frames = 0
        self._frames = 0
        self._busy_bits = 0
        self._nodes: list[CanNode] = []
        self._listeners: list[CanListener] = []
        self._late_listeners: list[LateCanListener] = []
        self._bursts = CanBursts(bitrate)
        self._keeps_bursts = False
        """Whether a set that finds the bus idle gets through undisturbed and nobody waits for it."""
        self._acknowledging_listeners = 0
        self._plan: deque[Transmission] = deque()
        self._run_start = 0
        self._run_bits = 0
        self._alone: CanNode | None = None
        self._any_off = False
        self._disturbances: list[Callable[[], None]] = []
        self._alarm = Alarm(time, self._due)

    # -- who is there ------------------------------------------------------------------------------

    def attach(self, node: CanNode) -> None:
        """Connect a node."""
        self.catch_up()
        self._nodes.append(node)
        self.replan()

    def detach(self, node: CanNode) -> None:
        """Take a node off the bus (no power, cable pulled); what it has queued is lost."""
        self.withdraw(node)
        self._nodes.remove(node)
        self.replan()

    def listen(self, callback: CanListener, acknowledges: bool = True) -> None:
        """Tell of every frame that gets through: `callback(frame, end_ns)`, at `end_ns` or somewhat later.

        An analyser acknowledges as every node does; a silent one does not.
        """
        self.catch_up()
        self._listeners.append(callback)
        self._acknowledging_listeners += acknowledges
        self.replan()

    def listen_late(self) -> LateCanListener:
        """An analyser that is asked for what it has heard. It acknowledges."""
        self.catch_up()
        listener = LateCanListener(self)
        self._late_listeners.append(listener)
        self._acknowledging_listeners += 1
        self.replan()
        return listener

    @property
    def frames(self) -> int:
        """Frames that got through, up to now."""
        self.catch_up()
        return self._frames

    @property
    def busy_ns(self) -> int:
        """Time taken up by frames with their interframe space and by error frames, up to now."""
        self.catch_up()
        return self._busy_bits * SECOND // self.bitrate

    # -- disturbance -------------------------------------------------------------------------------

    def begin_disturbance(self, strike: Callable[[], None]) -> None:
        """From now on no frame gets through, nor does the one under way; `strike` hears of each failure."""
        self.catch_up()
        self._disturbances.append(strike)
        self._take_back_plan()
        self._break_frame_under_way()
        self.replan()

    def end_disturbance(self, strike: Callable[[], None]) -> None:
        """The disturbance with this `strike` has passed."""
        self.catch_up()
        if self._plan and not self._plan[0].succeeds and self._plan[0].begin < self.time.now:
            strike()
        self._disturbances.remove(strike)
        for node in self._nodes:
            if node.off_until == FAR and not self._disturbances:
                node.off_until = self.time.now + RECOVERY_BITS * SECOND // self.bitrate
        self.replan()

    # -- for the nodes -----------------------------------------------------------------------------

    def carry(self, node: CanNode, frames: Sequence[CanFrame], count: int) -> bool:
        """Take all `count` frames of `node` the short way; False when they have to be queued and planned.

        Raises ValueError for a frame that CAN does not have.
        """
        now = self.time.now
        bursts = self._bursts
        if not self._keeps_bursts or self._plan or now < bursts.over_by or node.error_count:
            return False
        if not 0 < count <= node.depth:
            return False
        if not bursts.kept and now < self._instant(self._run_bits):
            return False
        bursts.keep(now, node, frames, count)
        if len(bursts.kept) > MOST_KEPT:
            self.catch_up()
        return True

    def catch_up(self) -> None:
        """Settle everything that has ended by now."""
        now = self.time.now
        if self._bursts.kept:
            self._unfold_bursts()
        self._settle_ended()
        if self._alone is not None:
            self._settle_unacknowledged(self._alone)
        if self._any_off:
            self._bring_back(now)

    def replan(self) -> None:
        """Arbitrate anew for everything that has not begun."""
        now = self.time.now
        self._take_back_plan()
        if not self._plan and now >= self._instant(self._run_bits):
            self._run_start, self._run_bits = now, 0
        self._alone = None
        while ready := [node for node in self._nodes if node.queue and node.off_until is None]:
            # The lowest bits win the arbitration; of two equal frames that of the node attached first.
            node = ready[0] if len(ready) == 1 else min(ready, key=_urgency)
            if self._disturbances:
                self._plan_failure(node)
                break
            if not self._acknowledged(node):
                self._alone = node
                break
            if len(ready) == 1:
                self._add_all(node)
                break
            length = node.queue[0][1]
            self._add(node, length, length + INTERFRAME_BITS, succeeds=True)
        self._keeps_bursts = not (
            self._disturbances
            or self._any_off
            or self._listeners
            or self._alone is not None
            or not self._acknowledging_listeners
            or any(node.prompt for node in self._nodes)
        )
        self._alarm.by(self._next_instant())

    def withdraw(self, node: CanNode) -> None:
        """Forget what `node` has queued; a frame of its that is under way breaks off."""
        self.catch_up()
        self._take_back_plan()
        if self._plan and self._plan[0].node is node:
            self._break_frame_under_way()
        node.queue.clear()
        self.replan()

    # -- planning ----------------------------------------------------------------------------------

    def _unfold_bursts(self) -> None:
        """Settle the kept sets; of the last one, what has not ended becomes planned frames."""
        now = self.time.now
        bursts = self._bursts.take()
        ended = bursts if now >= self._bursts.over_by else bursts[:-1]
        alone = not self._listeners and len(self._nodes) == 1
        heard = heard_sets(ended, self.bitrate) if alone and ended else None
        if heard is not None:
            self._frames += len(heard)
            self._busy_bits += heard.bits
            for late in self._late_listeners:
                late.hear_all(heard)
            self._run_start, self._run_bits = now, 0
            bursts = bursts[len(ended) :]
        for begin, node, frames in bursts:
            self._run_start, self._run_bits = begin, 0
            node.queue.extend([(frame, frame_bits(frame)) for frame in frames])
            self._add_all(node)
            self._settle_ended()

    def _settle_ended(self) -> None:
        plan = self._plan
        while plan and plan[0].end <= self.time.now:
            self._settle(plan.popleft())

    def _instant(self, bits: int) -> int:
        return self._run_start + bits * SECOND // self.bitrate

    def _take_back_plan(self) -> None:
        """Put every frame that has not begun back into its node's queue."""
        plan = self._plan
        while plan and plan[-1].begin >= self.time.now:
            planned = plan.pop()
            planned.node.queue.appendleft((planned.frame, planned.length))
            planned.node.planned -= 1
            self._run_bits -= planned.bits

    def _acknowledged(self, sender: CanNode) -> bool:
        return self._acknowledging_listeners > 0 or any(
            node is not sender and node.off_until is None for node in self._nodes
        )

    def _plan_failure(self, node: CanNode) -> None:
        """One attempt that the disturbance breaks right behind the arbitration field."""
        bits = (33 if node.queue[0][0].extended else 13) + ACTIVE_FLAG_BITS + ECHO_BITS + DELIMITER_BITS
        bits += INTERFRAME_BITS + _suspend_bits(node)
        self._add(node, bits, bits, succeeds=False)

    def _add(self, node: CanNode, duration: int, bits: int, succeeds: bool) -> None:
        start, rate, at = self._run_start, self.bitrate, self._run_bits
        begin = start + at * SECOND // rate
        end = start + (at + duration) * SECOND // rate
        frame, length = node.queue.popleft()
        self._plan.append(Transmission(begin, end, node, frame, length, bits, succeeds))
        self._run_bits = at + bits
        node.planned += 1

    def _add_all(self, node: CanNode) -> None:
        """Frame behind frame of the only node that has any: `_add` for a whole burst, at less cost."""
        start, rate, at = self._run_start, self.bitrate, self._run_bits
        plan = self._plan
        for frame, length in node.queue:
            begin = start + at * SECOND // rate
            end = start + (at + length) * SECOND // rate
            bits = length + INTERFRAME_BITS
            plan.append(Transmission(begin, end, node, frame, length, bits, True))
            at += bits
        self._run_bits = at
        node.planned += len(node.queue)
        node.queue.clear()

    def _next_instant(self) -> int:
        plan = self._plan
        due = FAR
        if self._any_off:
            due = min(node.off_until for node in self._nodes if node.off_until is not None)
        if not plan:
            return due
        first = plan[0]
        if not first.succeeds:
            return min(due, first.end)
        for node in self._nodes:
            if node.prompt and node is not first.node:
                return min(due, first.end)
        return min(due, plan[-1].end)

    def _due(self) -> int:
        some_were_off = self._any_off
        self.catch_up()
        if some_were_off or (not self._plan and any(node.queue for node in self._nodes)):
            self.replan()
        return self._next_instant()

    # -- what came of it ---------------------------------------------------------------------------

    def _settle(self, done: Transmission) -> None:
        sender = done.node
        sender.planned -= 1
        if done.succeeds:
            self._get_through(sender, done.frame, done.end, done.bits)
            return
        self._busy_bits += done.bits
        sender.queue.appendleft((done.frame, done.length))
        self._count_failure(sender)

    def _get_through(self, sender: CanNode, frame: CanFrame, end: int, bits: int) -> None:
        self._busy_bits += bits
        self._frames += 1
        if sender.error_count:
            sender.error_count -= 1
        for node in self._nodes:
            if node is not sender and node.off_until is None:
                node.deliver(frame, end)
        for listener in self._listeners:
            listener(frame, end)
        for late in self._late_listeners:
            late.hear(frame, end, sender.name)

    def _count_failure(self, node: CanNode) -> None:
        for strike in self._disturbances:
            strike()
        self.error_frames += 1
        node.attempts_failed += 1
        node.error_count += 8
        if node.error_count >= BUS_OFF:
            recovery = self.time.now + RECOVERY_BITS * SECOND // self.bitrate
            node.off_until = FAR if self._disturbances else recovery
            self._any_off = True

    def _bring_back(self, now: int) -> None:
        """Nodes whose time of bus-off is over take part again."""
        for node in self._nodes:
            if node.off_until is not None and node.off_until <= now:
                node.off_until = None
                node.error_count = 0
        self._any_off = any(node.off_until is not None for node in self._nodes)

    def _break_frame_under_way(self) -> None:
        """The frame on the wire ends in an error frame now and will be sent again."""
        if not self._plan:
            return
        broken = self._plan.popleft()
        elapsed = -(-(self.time.now - self._run_start) * self.bitrate // SECOND)
        error = ACTIVE_FLAG_BITS + ECHO_BITS + DELIMITER_BITS + INTERFRAME_BITS + _suspend_bits(broken.node)
        began = self._run_bits - broken.bits
        self._run_bits = elapsed + error
        self._busy_bits += self._run_bits - began
        broken.node.planned -= 1
        broken.node.queue.appendleft((broken.frame, broken.length))
        self._count_failure(broken.node)

    def _settle_unacknowledged(self, node: CanNode) -> None:
        """Count the attempts of a node alone on the bus that began before now, without an event for each."""
        failing = node.queue[0][1] - 8 + ACTIVE_FLAG_BITS + DELIMITER_BITS + INTERFRAME_BITS
        while (now := self.time.now) > self._instant(self._run_bits):
            if node.error_count < ERROR_PASSIVE:
                attempts, bits = 1, failing
                node.error_count += 8
            else:
                bits = failing + SUSPEND_BITS
                late = now - self._instant(self._run_bits)
                attempts = max(1, late * self.bitrate // (bits * SECOND))
            self._run_bits += attempts * bits
            self._busy_bits += attempts * bits
            self.error_frames += attempts
            node.attempts_failed += attempts


def _suspend_bits(node: CanNode) -> int:
    """An error-passive node waits before it sends again."""
    return SUSPEND_BITS if node.error_count >= ERROR_PASSIVE else 0


def _urgency(node: CanNode) -> int:
    return arbitration_key(node.queue[0][0])
