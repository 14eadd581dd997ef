"""The transmit buffer, its overrun, and the moment at which a new baud rate acts."""

import pytest
from neo_m8n_rig import MILLISECOND, SECOND, Rig, lines, nmea, nmea_messages, quiet_rig, ubx, ubx_messages

PRT_115200 = "B5 62 06 00 14 00 01 00 00 00 D0 08 00 00 00 C2 01 00 07 00 03 00 00 00 00 00 C0 7E"


class RecordingLine:
    """A line that only notes what is done to it; it has no more than the two required methods."""

    def __init__(self, rig: Rig) -> None:
        self.rig = rig
        self.log: list[tuple[int, bytes | int]] = []

    def send(self, data: bytes) -> int:
        self.log.append((self.rig.time.now, data))
        return len(data)

    def set_baud(self, baud: int) -> None:
        self.log.append((self.rig.time.now, baud))


def test_the_acknowledgement_leaves_at_the_old_rate_and_the_rest_at_the_new_one() -> None:
    rig = quiet_rig()
    rig.say(PRT_115200)
    rig.say(ubx(6, 8))
    assert rig.wire.baud == 9600
    rig.run(0.1)
    ack_time, ack = rig.host.chunks[-2]
    assert ack == ubx(5, 1, b"\x06\x00")
    assert ack_time == 5 * SECOND + 100 * SECOND // 9600  # ten bytes
    reply_time, reply = rig.host.chunks[-1]
    assert [m.identity for m in ubx_messages(reply)] == ["CFG-RATE", "ACK-ACK"]
    character = 10 * SECOND // 9600
    assert reply_time - ack_time == pytest.approx(character + len(reply) * 10 * SECOND / 115_200, abs=2)
    assert rig.chip.baud == rig.wire.baud == 115_200


def test_a_baud_change_waits_for_the_burst_under_way() -> None:
    rig = Rig()
    rig.run_to(3 * SECOND + 100 * MILLISECOND)
    rig.say(PRT_115200)
    rig.run(0.8)
    burst = b"".join(data for time, data in rig.host.chunks if time > 3 * SECOND)
    sentences, _, rest = burst.partition(b"\xb5\x62")
    assert len(nmea_messages(sentences)) == 9
    assert rest == ubx(5, 1, b"\x06\x00")[2:]


def test_two_changes_in_a_row_end_at_the_second() -> None:
    rig = quiet_rig()
    rig.say(PRT_115200)
    rig.say(nmea("PUBX,41,1,0007,0003,38400,0"))
    rig.run(0.2)
    assert rig.chip.baud == rig.wire.baud == 38_400


def overloaded() -> Rig:
    """The default set at 5 Hz: about 2200 bytes a second on a line for 960."""
    rig = Rig()
    rig.run(1.9)
    rig.say("B5 62 06 08 06 00 C8 00 01 00 01 00 DE 6A")
    return rig


def test_overrun_drops_whole_sentences_and_says_so_once_a_second() -> None:
    rig = overloaded()
    data = rig.run(20.0)
    sentences = data.replace(ubx(5, 1, b"\x06\x08"), b"")
    printed = lines(sentences[: sentences.rindex(b"\r\n") + 2])
    assert len(nmea_messages("\r\n".join([*printed, ""]).encode())) == len(printed)
    assert rig.chip.messages_dropped > 100
    warnings = printed.count("$GNTXT,01,01,00,txbuf alloc*61")
    assert 10 <= warnings <= 19


def test_the_buffer_is_bounded() -> None:
    rig = overloaded()
    most = 0
    for _ in range(100):
        rig.run(0.1)
        most = max(most, rig.wire.queued)
    assert 1900 < most <= 2048


def test_the_line_recovers_when_the_load_goes() -> None:
    rig = overloaded()
    rig.run(10.0)
    rig.say("B5 62 06 08 06 00 E8 03 01 00 01 00 01 39")
    rig.run(5.0)
    dropped = rig.chip.messages_dropped
    data = rig.run(5.0)
    assert rig.chip.messages_dropped == dropped
    assert b"txbuf" not in data


def test_a_line_that_cannot_be_cut_is_enough() -> None:
    rig = Rig(powered=False)
    line = RecordingLine(rig)
    from boards.chips.neo_m8n import NeoM8n

    chip = NeoM8n(rig.time, rig.world, line, start_state="hot")
    rig.run(2.5)
    chip.power(False)
    assert line.log[0] == (250 * MILLISECOND, 9600)
    assert [time for time, entry in line.log if isinstance(entry, bytes)] == [
        250 * MILLISECOND,
        1080 * MILLISECOND,
        2080 * MILLISECOND,
    ]


def test_a_reset_now_cuts_the_line_and_a_controlled_one_lets_it_finish() -> None:
    for mode, cut in ((0, True), (1, False), (4, False)):
        rig = Rig()
        rig.run_to(3 * SECOND + 100 * MILLISECOND)
        rig.say(ubx(6, 4, bytes((0, 0, mode, 0))))
        data = rig.run(1.5)
        assert (b"GLL" in data.partition(b"$GNTXT")[0]) is not cut
        assert data.count(b"u-blox AG") == 1
