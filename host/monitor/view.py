"""The picture: panels for every size of a terminal, from one column to a wall.

view = MonitorView("a board")
view.feed(data, at_s)                      # bytes of the host link, or
view.take(messages, at_s)                  # what a LinkDecoder has made of them
console.print(view.render(80, 24))         # or rich.live.Live
"""

from __future__ import annotations

from collections.abc import Callable, Iterable

from rich.box import ROUNDED
from rich.console import Console, ConsoleOptions, RenderableType, RenderResult
from rich.layout import Layout
from rich.panel import Panel
from rich.segment import Segment
from rich.text import Text

from host.link.decoder import LinkDecoder
from host.link.messages import Solution, Status
from host.monitor.health_panels import event_lines, imu_lines, innovation_lines, link_lines, task_lines
from host.monitor.link_health import LinkHealth
from host.monitor.listener import Listener
from host.monitor.map import TrackMap
from host.monitor.motion_panels import attitude_lines, motion_lines
from host.monitor.receiver_panels import satellite_lines, sky_lines
from host.monitor.state import BoardState, Shown
from host.monitor.words import duration, mode_name, mode_style

Lines = Callable[[int, int], list[Text]]
SMALLEST = 10
"""Columns and rows are taken to be at least so many."""
LEAST_TITLE = 12
PLAIN_SIGNS = {"°": "d", "±": "~", "σ": "s", "µ": "u", "·": ".", "•": "o", "…": "."} | dict.fromkeys(
    "─━╸╺", "-"
)


class MonitorView:
    """State and counters of one board, and their picture."""

    def __init__(self, title: str, decoder: LinkDecoder | None = None) -> None:
        """`decoder`: the embedder's own, whose counts are shown; messages then come by `take`."""
        self.title = title
        self.source = ""
        """One line about where the data come from and how that is; its style below."""
        self.source_style = ""
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

    # -- arrangements ------------------------------------------------------------------------------

    def _layout(self, width: int, height: int) -> Layout:
        state = self.state
        told_more = state.solution or state.attitude or state.inertial or self.link.frames
        if state.gnss is not None and not told_more:
            body = self._receiver(width, height - 2)
        elif width < 60:
            body = self._narrow(height - 2)
        elif width < 108 or height < 34:
            body = self._small(width, height - 2)
        else:
            body = self._large(width, height - 2)
        root = Layout()
        root.split_column(
            Layout(self._head(width), size=1), body, Layout(_line(Text(self.hint or " ", "dim")), size=1)
        )
        return root

    def _narrow(self, height: int) -> Layout:
        parts = [("attitude", self._attitude, 11), ("position", self._motion, 10), ("link", self._link, 9)]
        parts += [("satellites", self._satellites, 10), ("events", self._events, 6)]
        body = Layout()
        shown: list[Layout] = []
        for title, lines, wanted in parts:
            if height >= wanted or not shown:
                shown.append(_panel(title, lines, size=min(wanted, height)))
                height -= wanted
        shown[-1].size = None
        body.split_column(*shown)
        return body

    def _small(self, width: int, height: int) -> Layout:
        """Two rows of three, a third one when there is room, events."""
        rows = [
            [("attitude", self._attitude), ("position", self._motion), ("track", self._track)],
            [("satellites", self._satellites), ("link", self._link), ("tasks", self._tasks)],
            [("innovations", self._innovations), ("inertial", self._imu)],
        ]
        if height < 34:
            rows[1:] = [
                [("satellites", self._satellites), ("link", self._link), ("tasks", self._tasks_and_nis)]
            ]
        events = min(max(height - 10 * len(rows), 4), 8)
        parts = []
        for row in rows:
            layout = Layout(ratio=1)
            layout.split_row(*(_panel(title, lines) for title, lines in row))
            parts.append(layout)
        body = Layout()
        body.split_column(*parts, _panel("events", self._events, size=events))
        return body

    def _receiver(self, width: int, height: int) -> Layout:
        """A receiver alone has less to tell."""
        upper, lower, body = Layout(ratio=1), Layout(ratio=1), Layout()
        upper.split_row(_panel("position", self._motion), _panel("track", self._track))
        seen = [_panel("satellites", self._satellites), _panel("sky", self._sky)]
        lower.split_row(*seen, _panel("line", self._link, size=min(34, width // 3)))
        body.split_column(upper, lower, *([_panel("events", self._events, size=5)] if height >= 30 else []))
        return body

    def _large(self, width: int, height: int) -> Layout:
        """Three columns and a row of events; the map is largest."""
        events = 6 if height < 44 else 9
        left, middle, right = Layout(size=max(width // 3, 38)), Layout(size=max(width // 3, 38)), Layout()
        left.split_column(
            _panel("attitude", self._attitude),
            _panel("inertial", self._imu, size=10),
            _panel("innovations", self._innovations, size=8),
        )
        middle.split_column(
            _panel("position", self._motion, size=13),
            _panel("link and flags", self._link, size=11),
            _panel("tasks", self._tasks),
        )
        sky = [_panel("sky", self._sky)] if width >= 150 else []
        lower = Layout(size=min(14, height // 3))
        lower.split_row(_panel("satellites", self._satellites), *sky)
        right.split_column(_panel("track", self._track), lower)
        columns = Layout()
        columns.split_row(left, middle, right)
        body = Layout()
        body.split_column(columns, _panel("events", self._events, size=events))
        return body

    # -- panels ------------------------------------------------------------------------------------

    def _head(self, width: int) -> RenderableType:
        solution = self.state.solution
        mode = solution.mode if solution is not None else None
        told = ("waiting for data", "yellow") if mode is None else (mode_name(mode), mode_style(mode))
        if mode is None and self.state.gnss is not None:
            told = (f"receiver: {self.state.fix}", "green")
        state = Text.assemble(told, f"  t {duration(self.state.at_s)}  ", (self.source, self.source_style))
        room = max(width - state.cell_len - 4, LEAST_TITLE)
        title = self.title if len(self.title) <= room else "…" + self.title[1 - room :]
        head = Text.assemble((f" {title} ", "bold reverse"), "  ", state, no_wrap=True)
        return _line(head)

    def _attitude(self, width: int, height: int) -> list[Text]:
        return attitude_lines(self.state, width, height)

    def _motion(self, width: int, height: int) -> list[Text]:
        return motion_lines(self.state, width, height)

    def _track(self, width: int, height: int) -> list[Text]:
        return self._map.lines(self.state.track, width, height)

    def _satellites(self, width: int, height: int) -> list[Text]:
        return satellite_lines(self.state, width, height)

    def _sky(self, width: int, height: int) -> list[Text]:
        return sky_lines(self.state, width, height)

    def _link(self, width: int, height: int) -> list[Text]:
        return link_lines(self.state, self.link, width, height)

    def _imu(self, width: int, height: int) -> list[Text]:
        return imu_lines(self.state, width, height)

    def _tasks(self, width: int, height: int) -> list[Text]:
        return task_lines(self.state, width, height)

    def _tasks_and_nis(self, width: int, height: int) -> list[Text]:
        """Tasks, and the innovations of position below, where there is no panel for them."""
        tasks = task_lines(self.state, width, max(height - 3, 1))
        return [*tasks, *innovation_lines(self.state, width, 3)][:height]

    def _innovations(self, width: int, height: int) -> list[Text]:
        return innovation_lines(self.state, width, height)

    def _events(self, width: int, height: int) -> list[Text]:
        return event_lines(self.state, width, height)


class Picture:
    """A layout of a fixed size; in a terminal that shows ASCII only, drawn with what that has."""

    def __init__(self, layout: Layout, width: int, height: int) -> None:
        self._layout = layout
        self._size = width, height

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        lines = console.render_lines(self._layout, options.update_dimensions(*self._size))
        for line in lines:
            for text, style, control in line:
                yield Segment(text if not options.ascii_only else text.translate(_AsPlain()), style, control)
            yield Segment.line()


class _AsPlain(dict[int, str]):
    """What stands for a sign in ASCII; every sign keeps its width."""

    def __missing__(self, code: int) -> str:
        sign = chr(code)
        if code < 0x80:
            return sign
        if 0x2800 < code <= 0x28FF:
            return "."
        if 0x2500 <= code < 0x2580:
            return "+"
        if 0x2580 <= code < 0x25A0:
            return "#"
        return PLAIN_SIGNS.get(sign, "?")


class _Lines:
    """Lines that are asked for once their room is known; cut there."""

    def __init__(self, lines: Lines) -> None:
        self._lines = lines

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        height = options.height or options.size.height
        for line in self._lines(max(options.max_width, 1), max(height, 1))[:height]:
            yield _line(line)


def _line(text: Text) -> Text:
    text.no_wrap = True
    text.overflow = "crop"
    return text


def _panel(title: str, lines: Lines, size: int | None = None) -> Layout:
    panel = Panel(
        _Lines(lines), title=title, title_align="left", box=ROUNDED, border_style="bright_black", padding=0
    )
    return Layout(panel, size=size)
