"""Checks for `hal.storage.LogFile`."""

from collections.abc import Callable
from typing import Protocol

from hal.storage import LogFile


class StorageBench(Protocol):
    """A log file and a way to look at what is safe in it."""

    log: LogFile
    cut_power: Callable[[], None] | None
    remove_card: Callable[[], None] | None

    def expect(self, action: str) -> None:
        """The call `action` (as in a transcript) comes next."""
        ...

    def contents(self) -> bytes:
        """The bytes that a power cut at this moment would leave."""
        ...


def _append(bench: StorageBench, data: bytes) -> bool:
    bench.expect(f"log sdcard append {data.hex(' ')}")
    return bench.log.append(data)


def _sync(bench: StorageBench) -> bool:
    bench.expect("log sdcard sync")
    return bench.log.sync()


def keeps_what_was_synced(bench: StorageBench) -> None:
    """In order, over several syncs, whatever the sizes."""
    pieces = [b"a", bytes(511), b"bc", bytes(range(256)) * 5, b"end"]
    for piece in pieces:
        assert _append(bench, piece), f"{len(piece)} bytes refused"
        assert _sync(bench)
    assert bench.contents() == b"".join(pieces)


def sync_of_nothing_is_fine(bench: StorageBench) -> None:
    """A file with nothing new is safe already."""
    assert _sync(bench)
    assert bench.contents() == b""


def power_cut_loses_only_the_rest(bench: StorageBench) -> None:
    """What was synced stays; the file goes on behind it."""
    if bench.cut_power is None:
        return
    assert _append(bench, b"safe")
    assert _sync(bench)
    assert _append(bench, b"lost" * 300)
    bench.cut_power()
    assert bench.contents() == b"safe"
    assert _append(bench, b" again")
    assert _sync(bench)
    assert bench.contents() == b"safe again"


def missing_card_is_told(bench: StorageBench) -> None:
    """Without a card both calls answer False and nothing else happens."""
    if bench.remove_card is None:
        return
    bench.remove_card()
    assert bench.log.append(b"x") is False
    assert bench.log.sync() is False
    assert bench.contents() == b""


CHECKS: tuple[Callable[[StorageBench], None], ...] = (
    keeps_what_was_synced,
    sync_of_nothing_is_fine,
    power_cut_loses_only_the_rest,
    missing_card_is_told,
)
