"""The picture: panels for every size of a terminal, from one column to a wall.

view = MonitorView("a board")
view.feed(data, at_s)                  # bytes of the host link, or
view.take(messages, at_s)              # what a LinkDecoder has made of them
console.print(view.render(80, 24))     # or rich.live.Live
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial

from rich.console import RenderableType
from rich.layout import Layout
from rich.text import Text

from firmware.link.frames import SOLUTION
from host.link.decoder import LinkDecoder
from host.link.messages import Solution, Status
from host.monitor.arrangement import Boxes, arranged, with_display
from host.monitor.display_panel import box_size, display_lines
from host.monitor.health_panels import event_lines, imu_lines, innovation_lines, link_lines, task_lines
from host.monitor.link_health import LinkHealth
from host.monitor.listener import Listener
from host.monitor.map import TrackMap
from host.monitor.motion_panels import attitude_lines, motion_lines
from host.monitor.picture import Picture, single
from host.monitor.receiver_panels import satellite_lines, sky_lines
from host.monitor.state import BoardState, Shown
from host.monitor.words import duration, mode_name, mode_style
from host.record.screens import Picture as DisplayPicture

SMALLEST = 10
"""Columns and rows are taken to be at least so many."""
LEAST_TITLE = 12
OLD_S = 2.5
"""A solution is told ten times a second, an epoch once: what is older than this has stopped."""


class MonitorView:
    """State and counters of one board, and their picture."""

    def __init__(self, title: str, decoder: LinkDecoder | None = None) -> None:
        """`decoder`: the embedder's own, whose counts are shown; messages then come by `take`."""
        self.title = title
        self.source = ""
        """One line about where the data come from and how that is; its style below."""
        self.source_style = ""
        self.display: DisplayPicture | None = None
        """What the board's own display shows; None: it has none, or it is dark."""
        self.hint = ""
        """The last line: keys, or what the user could do."""
        self._begin(decoder if decoder is not None else LinkDecoder())

    def _begin(self, decoder: LinkDecoder) -> None:
        self.state = BoardState()
        self.link = LinkHealth()
        self.listener = Listener(decoder)
        self._decoder = decoder
        self._map = TrackMap()

    def forget(self, at_s: float) -> None:
        """Begin anew at `at_s`, as if nothing had been said."""
        self._begin(LinkDecoder())
        self.state.at_s = at_s

    def feed(self, data: bytes, at_s: float) -> None:
        """Bytes of the board, or of a plain receiver, that came at `at_s`, s of the source's clock."""
        self.link.bytes += len(data)
        self.take(self.listener.feed(data, at_s), at_s)

    def time_passes(self, at_s: float) -> None:
        """Nothing came until `at_s`: a silence ends a receiver's burst."""
        if self.listener.receiver is not None:
            self.take(self.listener.feed(b"", at_s), at_s)
        self.state.at_s = max(self.state.at_s, at_s)
        self.link.note(at_s)

    def take(self, messages: Iterable[tuple[int, Shown]], at_s: float) -> None:
        """Messages that came at `at_s`."""
        restarts = self.state.restarts
        for kind, message in messages:
            self.state.take(kind, message, at_s)
            if isinstance(message, Solution | Status):
                if self.state.restarts != restarts:
                    restarts = self.state.restarts
                    self.link.forget_arrivals()
                self.link.note_arrival(message.time_us, at_s)
        receiver = self.listener.receiver
        if receiver is None:
            self.link.count(self._decoder, at_s)
        else:
            self.state.fix_name = receiver.fix_name
            self.link.count_receiver(receiver, at_s)

    def say(self, text: str) -> None:
        """An event of the embedder's."""
        self.state.say(text)

    def render(self, width: int, height: int) -> RenderableType:
        """The picture, exactly `width` × `height` characters."""
        return Picture(self._layout(max(width, SMALLEST), max(height, SMALLEST)), width, height)

    def _layout(self, width: int, height: int) -> Layout:
        state = self.state
        told_more = state.solution or state.attitude or state.inertial or self.link.frames
        receiver_only = state.gnss is not None and not told_more
        if self.display is None:
            body = arranged(self._boxes(), width, height - 2, receiver_only)
        else:
            body = with_display(self._boxes(), width, box_size(self.display, width, height - 2))
        root = Layout()
        hint = single(Text(self.hint or " ", "dim"))
        root.split_column(Layout(self._head(width), size=1), body, Layout(hint, size=1))
        return root

    def _boxes(self) -> Boxes:
        """What stands in each box."""
        state, link = self.state, self.link
        return {
            "attitude": partial(attitude_lines, state),
            "position": partial(motion_lines, state),
            "track": partial(self._map.lines, state.track),
            "satellites": partial(satellite_lines, state),
            "sky": partial(sky_lines, state),
            "link": partial(link_lines, state, link),
            "inertial": partial(imu_lines, state),
            "tasks": partial(task_lines, state),
            "tasks and innovations": self._tasks_and_innovations,
            "innovations": partial(innovation_lines, state),
            "events": partial(event_lines, state),
            "display": partial(display_lines, self.display) if self.display is not None else _nothing,
        }

    def _tasks_and_innovations(self, width: int, height: int) -> list[Text]:
        """Tasks, and the innovations of position below, where there is no box for them."""
        tasks = task_lines(self.state, width, max(height - 3, 1))
        return [*tasks, *innovation_lines(self.state, width, 3)][:height]

    def _head(self, width: int) -> RenderableType:
        solution = self.state.solution
        mode = solution.mode if solution is not None else None
        told = ("waiting for data", "yellow") if mode is None else (mode_name(mode), mode_style(mode))
        if mode is None and self.state.gnss is not None:
            told = (f"receiver: {self.state.fix}", "green")
        silent_s = self.state.at_s - self.state.seen_s.get(SOLUTION, self.state.at_s)
        if silent_s > OLD_S:
            told = (f"no solution for {silent_s:.0f} s", "bold red")
        state = Text.assemble(told, f"  t {duration(self.state.at_s)}  ", (self.source, self.source_style))
        room = max(width - state.cell_len - 4, LEAST_TITLE)
        title = self.title if len(self.title) <= room else "…" + self.title[1 - room :]
        head = Text.assemble((f" {title} ", "bold reverse"), "  ", state, no_wrap=True)
        return single(head)


def _nothing(_width: int, _height: int) -> list[Text]:
    return []
