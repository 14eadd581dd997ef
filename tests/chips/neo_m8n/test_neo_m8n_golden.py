"""A whole session, committed and compared: cold start, configuration while searching, fix, tunnel, polls.

The file holds what crossed the wire in both directions, with the virtual time of each chunk's end. It is
reviewed as a diff; NAVTWIN_UPDATE_GOLDEN=1 writes it anew.
"""

import os
from dataclasses import replace
from pathlib import Path

from neo_m8n_rig import MILLISECOND, SECOND, SKY, Rig, nmea, ubx

GOLDEN = Path(__file__).with_name("golden_session.txt")


def stamp(time_ns: int) -> str:
    return f"{time_ns // SECOND:3d}.{time_ns % SECOND:09d}"


def shown(data: bytes) -> list[str]:
    """Sentences as text, frames as hex, in order."""
    out: list[str] = []
    while data:
        if data.startswith(b"\xb5\x62"):
            size = 8 + int.from_bytes(data[4:6], "little")
            out.append(data[:size].hex(" "))
        else:
            size = data.index(b"\r\n") + 2
            out.append(data[: size - 2].decode("ascii"))
        data = data[size:]
    return out


def session() -> str:
    rig = Rig(start_state="cold", listen=True)
    commands: list[tuple[int, bytes]] = []

    def say(at_s: float, data: bytes) -> None:
        rig.run_to(round(at_s * SECOND))
        commands.append((rig.time.now, data))
        rig.say(data)

    say(2.5, ubx(0x0A, 0x04))
    say(3.9, ubx(6, 0x01, b"\xf0\x01\x00"))  # GLL off
    say(4.9, ubx(6, 0x00, bytes.fromhex("01000000d0080000009600000700030000000000")))  # 38400 baud
    say(5.5, ubx(6, 0x01, b"\x01\x07\x05"))  # NAV-PVT every fifth epoch
    say(5.6, ubx(6, 0x16, bytes(8)))  # not modelled
    say(5.7, ubx(6, 0x31))
    say(5.8, ubx(6, 0x24))
    say(21.5, nmea("PUBX,04"))
    say(28.5, nmea("PUBX,00") + nmea("PUBX,03") + nmea("PUBX,04"))
    say(28.7, ubx(6, 0x17, bytes.fromhex("0041000200000000000000010000000000000000")))  # NMEA 4.1
    rig.run_to(29 * SECOND + 500 * MILLISECOND)
    rig.world.set(fix=False, satellites=tuple(replace(sat, cn0_dbhz=0.0, used=False) for sat in SKY))
    say(31.5, ubx(1, 0x07))
    rig.world.set(fix=True, satellites=SKY)
    say(32.6, nmea("PUBX,41,1,0007,0003,9600,0"))
    say(33.8, ubx(6, 4, bytes.fromhex("ffff0100")))
    rig.run_to(35 * SECOND)

    events = [(time, 0, "pulse", "high" if level else "low") for time, level in rig.edges]
    events += [(time, 1, "host ", text) for time, data in commands for text in shown(data)]
    events += [(time, 2, "gnss ", text) for time, data in rig.host.chunks for text in shown(data)]
    events.sort(key=lambda event: event[:2])
    return "".join(f"{stamp(time)} {who} {text}\n" for time, _, who, text in events)


def test_golden_session() -> None:
    text = session()
    if os.environ.get("NAVTWIN_UPDATE_GOLDEN"):
        GOLDEN.write_text(text)
    assert text.splitlines() == GOLDEN.read_text().splitlines()
