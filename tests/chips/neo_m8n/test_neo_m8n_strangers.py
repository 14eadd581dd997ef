"""Configuration sequences of public drivers, over real wires with the host's own baud rate.

The sequences are told in prose in the public sources of PX4 (GPSDrivers, ubx.cpp), ArduPilot (AP_GPS), the
SparkFun GNSS library and gpsd (driver_ubx.c); they are written anew here.
"""

import struct
from collections.abc import Callable
from typing import Any

from neo_m8n_rig import MILLISECOND, SECOND, Host, Rig, nmea, ubx, ubx_messages


class Port:
    """A host's serial port on a receiver: both directions at one baud rate, garbled when it is wrong."""

    def __init__(self, rig: Rig) -> None:
        self.rig = rig
        self.host = Host()
        rig.wire.connect(self.host, rate_of=rig.command_wire)
        self._read = 0

    def set_baud(self, baud: int) -> None:
        self.rig.command_wire.set_baud(baud)

    def write(self, data: bytes) -> None:
        self.rig.command_wire.send(data)

    def flush(self, milliseconds: int = 20) -> None:
        self.rig.run_to(self.rig.time.now + milliseconds * MILLISECOND)
        self._read = len(self.host.data)

    def wait_for(self, wanted: Callable[[Any], bool], milliseconds: int) -> Any:
        """The first message that `wanted` accepts, or None at the time-out."""
        end = self.rig.time.now + milliseconds * MILLISECOND
        while self.rig.time.now < end:
            self.rig.run_to(min(self.rig.time.now + 5 * MILLISECOND, end))
            for message in ubx_messages(self.host.data[self._read :], broken=0):
                if wanted(message):
                    self._read = len(self.host.data)
                    return message
        return None

    def acknowledged(self, message_id: int, milliseconds: int) -> bool | None:
        """ACK True, NAK False, nothing None."""
        answer = self.wait_for(
            lambda m: m.identity.startswith("ACK") and (m.clsID, m.msgID) == (6, message_id), milliseconds
        )
        return None if answer is None else answer.identity == "ACK-ACK"


def port_block(port: int, baud: int, in_mask: int, out_mask: int) -> bytes:
    return struct.pack("<BBHIIHHHH", port, 0, 0, 0x08D0, baud, in_mask, out_mask, 0, 0)


def test_px4_finds_the_baud_rate_and_configures_the_receiver() -> None:
    rig = Rig()
    port = Port(rig)
    rig.run(4.321)
    found = None
    for baud in (38400, 57600, 9600, 115200):
        port.set_baud(baud)
        port.flush()
        port.write(ubx(6, 0x8A, bytes((0, 1, 0, 0)) + bytes.fromhex("010052400080250000")))  # newer products
        assert port.acknowledged(0x8A, 2000) is not True
        both_ports = port_block(1, baud, 0x21, 0x01) + port_block(3, baud, 0x21, 0x01)
        port.write(ubx(6, 0x00, both_ports))
        if port.acknowledged(0x00, 250):
            found = baud
            break
    assert found == 9600
    port.write(ubx(6, 0x00, port_block(1, 38400, 0x21, 0x01) + port_block(3, 38400, 0x21, 0x01)))
    port.acknowledged(0x00, 250)
    port.set_baud(38400)
    port.flush()
    port.write(ubx(0x0A, 0x04))
    version = port.wait_for(lambda m: m.identity == "MON-VER", 250)
    assert version.hwVersion.startswith(b"00080000")
    port.write(ubx(6, 0x08, struct.pack("<HHH", 200, 1, 0)))
    assert port.acknowledged(0x08, 250)
    port.write(ubx(6, 0x24, struct.pack("<HBB", 0x0005, 7, 2) + bytes(32)))
    assert port.acknowledged(0x24, 250)
    systems = bytes.fromhex(
        "0000ff07 0008100001000100 0500030001000100 0101030001000100"
        "0200000000000000 0300000000000000 06080e0001000100 0400000000000000"
    )
    port.write(ubx(6, 0x3E, systems))
    assert port.acknowledged(0x3E, 250)
    for message in ((1, 0x07, 1), (1, 0x03, 1), (1, 0x04, 1), (1, 0x30, 5), (0x0A, 0x09, 1)):
        port.write(ubx(6, 0x01, bytes(message)))
        assert port.acknowledged(0x01, 250)
    port.flush(3000)
    heard = {m.identity for m in ubx_messages(rig.host.data[-3000:], broken=0)}
    assert heard == {"NAV-PVT", "NAV-STATUS", "NAV-DOP", "NAV-SVINFO", "MON-HW"}
    assert rig.chip.messages_dropped == 0


def test_ardupilot_switches_by_a_blob_of_ubx_and_pubx() -> None:
    rig = Rig()
    port = Port(rig)
    blob = bytes.fromhex("B5 62 06 01 03 00 01 06 01 12 4F") + b"$PUBX,41,1,0023,0001,115200,0*1C\r\n"
    rig.run(2.0)
    for baud in (230_400, 57_600, 9600):
        port.set_baud(baud)
        port.write(blob)
        port.flush(1200)
    port.set_baud(115_200)
    port.flush(1500)
    rig.host.chunks.clear()
    assert port.wait_for(lambda m: m.identity == "NAV-SOL" and m.gpsFix == 3, 1500)
    port.write(ubx(6, 0x01, b"\x01\x07"))
    assert port.wait_for(lambda m: m.identity == "CFG-MSG", 300)
    port.write(ubx(6, 0x3E))
    systems = port.wait_for(lambda m: m.identity == "CFG-GNSS", 300)
    assert systems.numConfigBlocks == 7
    port.write(ubx(6, 0x00))
    assert port.wait_for(lambda m: m.identity == "CFG-PRT", 300).baudRate == 115_200
    assert b"$G" not in rig.host.data


def test_sparkfun_reads_settings_before_it_changes_and_saves_them() -> None:
    rig = Rig()
    port = Port(rig)
    rig.run(3.0)
    port.write(ubx(6, 0x00, b"\x01"))
    settings = port.wait_for(lambda m: m.identity == "CFG-PRT", 1100)
    changed = bytearray(settings.payload)
    changed[14] = 0x01
    port.write(ubx(6, 0x00, bytes(changed)))
    assert port.acknowledged(0x00, 1100)
    port.write(ubx(6, 0x08))
    rate = port.wait_for(lambda m: m.identity == "CFG-RATE", 1100)
    port.write(ubx(6, 0x08, struct.pack("<H", 250) + rate.payload[2:]))
    assert port.acknowledged(0x08, 1100)
    port.write(ubx(6, 0x01, b"\x01\x07"))
    rates = bytearray(port.wait_for(lambda m: m.identity == "CFG-MSG", 1100).payload)
    rates[3] = 1
    port.write(ubx(6, 0x01, bytes(rates)))
    assert port.acknowledged(0x01, 1100)
    port.write(ubx(6, 0x09, struct.pack("<III", 0, 0xFFFF, 0)))
    assert port.acknowledged(0x09, 1100)
    port.write(ubx(6, 0x04, bytes((0, 0, 0, 0))))
    port.flush(3000)
    first = port.wait_for(lambda m: m.identity == "NAV-PVT", 1000)
    second = port.wait_for(lambda m: m.identity == "NAV-PVT", 1000)
    assert (second.iTOW - first.iTOW) % 250 == 0
    assert first.fixType == 3


def test_gpsd_asks_around_and_sets_rates_without_waiting() -> None:
    rig = Rig()
    port = Port(rig)
    rig.run(3.0)
    polls = [ubx(0x0A, 0x04), ubx(6, 0x00), ubx(6, 0x24), ubx(6, 0x08), ubx(6, 0x16), ubx(6, 0x3E)]
    port.write(b"".join(polls))
    for message in ((1, 0x04), (1, 0x06), (1, 0x20), (1, 0x22), (1, 0x26), (1, 0x32), (1, 0x35)):
        port.write(ubx(6, 0x01, bytes((*message, 1))))
    for message_id in range(0x0B):
        port.write(ubx(6, 0x01, bytes((0xF0, message_id, 0))))
    port.flush(4000)
    answers = [m.identity for m in ubx_messages(port.host.data, broken=0)]
    for wanted in ("MON-VER", "CFG-PRT", "CFG-NAV5", "CFG-RATE", "CFG-GNSS", "NAV-DOP", "NAV-SOL", "NAV-SAT"):
        assert wanted in answers
    assert answers.count("ACK-NAK") == 2  # CFG-SBAS and NAV-SBAS are not modelled
    assert answers.count("ACK-ACK") == 4 + 6 + 11


def test_a_terminal_that_changes_speed_by_pubx() -> None:
    rig = Rig()
    port = Port(rig)
    rig.run(3.0)
    assert nmea("PUBX,41,1,0007,0003,19200,0") == b"$PUBX,41,1,0007,0003,19200,0*25\r\n"
    port.write(nmea("PUBX,41,1,0007,0003,19200,0"))
    port.flush(800)
    port.set_baud(19_200)
    port.flush(50)
    rig.run_to((rig.time.now // SECOND + 2) * SECOND)
    assert b"$GNRMC" in port.host.data[-600:]
    assert rig.chip.baud == 19_200
