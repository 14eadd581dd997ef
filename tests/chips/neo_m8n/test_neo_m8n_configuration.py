"""Configuration over UBX and PUBX: the fact sheet's frames, answers, memories, and limits."""

import struct

import pytest
from neo_m8n_rig import SECOND, Rig, line, lines, nmea, nmea_messages, ubx, ubx_messages

ACK_RATE = bytes.fromhex("B5 62 05 01 02 00 06 08 16 3F")
NAK_MSG = bytes.fromhex("B5 62 05 00 02 00 06 01 0E 33")
PRT_9600 = "B5 62 06 00 14 00 01 00 00 00 D0 08 00 00 80 25 00 00 07 00 03 00 00 00 00 00 A2 B5"
PRT_115200 = "B5 62 06 00 14 00 01 00 00 00 D0 08 00 00 00 C2 01 00 07 00 03 00 00 00 00 00 C0 7E"
RATE_1_HZ = "B5 62 06 08 06 00 E8 03 01 00 01 00 01 39"
RATE_5_HZ = "B5 62 06 08 06 00 C8 00 01 00 01 00 DE 6A"
PVT_ON = "B5 62 06 01 03 00 01 07 01 13 51"
GLL_OFF = "B5 62 06 01 03 00 F0 01 00 FB 11"

PRT, MSG, INF, RST, RATE, CFG, NMEA, NAV5, TP5, GNSS = 0, 1, 2, 4, 8, 9, 0x17, 0x24, 0x31, 0x3E


def identities(messages: list) -> list[str]:
    return [message.identity for message in messages]


def test_the_fact_sheets_frames_are_acknowledged_byte_for_byte(rig: Rig) -> None:
    for frame in (RATE_1_HZ, RATE_5_HZ):
        rig.say(frame)
        assert rig.run(0.5) == ACK_RATE
    rig.say(GLL_OFF)
    assert rig.run(0.5) == bytes.fromhex("B5 62 05 01 02 00 06 01 0F 38")
    rig.say(ubx(6, MSG, bytes((0x77, 0x77, 1))))
    assert rig.run(0.5) == NAK_MSG
    rig.say(PRT_9600)
    assert rig.run(0.5) == bytes.fromhex("B5 62 05 01 02 00 06 00 0E 37")


def test_monver_strings_are_laid_out_as_documented(rig: Rig) -> None:
    rig.say("B5 62 0A 04 00 00 0E 34")
    raw = rig.run(0.9)
    length = struct.unpack_from("<H", raw, 4)[0]
    assert (length - 40) % 30 == 0
    payload = raw[6 : 6 + length]
    assert payload[:30].rstrip(b"\0") == b"EXT CORE 3.01 (111141)"
    assert payload[30:40].rstrip(b"\0") == b"00080000"
    extensions = [payload[start : start + 30].rstrip(b"\0") for start in range(40, length, 30)]
    assert b"PROTVER=18.00" in extensions
    assert b"FWVER=SPG 3.01" in extensions
    assert b"MOD=NEO-M8N-0" in extensions
    assert all(text.isascii() and text for text in extensions)


@pytest.mark.parametrize(
    ("message_id", "payload", "answer"),
    [
        (PRT, b"", bytes.fromhex(PRT_9600)),
        (PRT, b"\1", bytes.fromhex(PRT_9600)),
        (RATE, b"", bytes.fromhex(RATE_1_HZ)),
        (MSG, b"\xf0\x04", ubx(6, 1, bytes.fromhex("f004010001010101"))),
        (MSG, b"\x01\x07", ubx(6, 1, bytes.fromhex("0107000000000000"))),
        (INF, b"\1", ubx(6, 2, bytes.fromhex("01000000070707070707"))),
        (
            TP5,
            b"",
            ubx(6, 0x31, struct.pack("<BBHhhIIIIiI", 0, 1, 0, 50, 0, 10**6, 10**6, 0, 10**5, 0, 0xF7)),
        ),
    ],
)
def test_polls_are_answered_with_the_setting_and_an_ack(
    rig: Rig, message_id: int, payload: bytes, answer: bytes
) -> None:
    rig.say(ubx(6, message_id, payload))
    assert rig.run(0.5) == answer + ubx(5, 1, bytes((6, message_id)))


@pytest.mark.parametrize(("message_id", "size"), [(NAV5, 36), (NMEA, 20), (GNSS, 60)])
def test_further_polls_have_the_documented_size(rig: Rig, message_id: int, size: int) -> None:
    messages = rig.ask(ubx(6, message_id))
    assert [len(message.payload) for message in messages] == [size, 2]
    assert messages[1].identity == "ACK-ACK"


@pytest.mark.parametrize(
    ("message_id", "payload"),
    [
        (PRT, bytes(19)),
        (PRT, bytes.fromhex("02000000d0080000802500000700030000000000")),  # no UART2
        (PRT, bytes.fromhex("01000000d0080000010000000700030000000000")),  # 1 baud
        (PRT, bytes.fromhex("01000000c0000000802500000700030000000000")),  # 8E1
        (MSG, bytes(5)),
        (RATE, bytes(6)),
        (RATE, bytes.fromhex("e8030000 0100")),
        (CFG, bytes(11)),
        (RST, bytes(3)),
        (RST, bytes((0, 0, 7, 0))),
        (NMEA, bytes(20)),
        (NMEA, bytes(7)),
        (NMEA, bytes.fromhex("0040000300000000000000010000000000000000")),  # compatibility mode
        (NAV5, bytes(35)),
        (NAV5, bytes.fromhex("0100 0c") + bytes(33)),
        (TP5, b"\1" + bytes(31)),
        (TP5, struct.pack("<BBHhhIIIIiI", 0, 1, 0, 0, 0, 10, 10, 5, 5, 0, 0x77)),  # 100 kHz
        (TP5, struct.pack("<BBHhhIIIIiI", 0, 1, 0, 0, 0, 10**6, 10**6, 0, 2 * 10**6, 0, 0x77)),
        (GNSS, bytes.fromhex("00202001 0008100000000101 ff")),
        (GNSS, bytes.fromhex("00202002 0008100000000101 06080e0000000101")),  # nothing left
        (GNSS, bytes.fromhex("00202001 0308100001000101")),  # three frequency bands
        (INF, bytes((2,))),
        (0x16, bytes(8)),  # SBAS: not modelled
        (0x8A, bytes(10)),  # VALSET: a later generation
    ],
)
def test_what_is_malformed_or_not_modelled_is_refused(rig: Rig, message_id: int, payload: bytes) -> None:
    before = [rig.ask(ubx(6, poll))[0].payload for poll in (PRT, RATE, NMEA, NAV5, TP5, GNSS)]
    rig.say(ubx(6, message_id, payload))
    assert rig.run(0.5) == ubx(5, 0, bytes((6, message_id)))
    assert [rig.ask(ubx(6, poll))[0].payload for poll in (PRT, RATE, NMEA, NAV5, TP5, GNSS)] == before


def test_what_the_model_leaves_out_is_reported_once_with_a_count(rig: Rig) -> None:
    for _ in range(3):
        rig.say(ubx(6, 0x16, bytes(8)))
    rig.say(ubx(6, MSG, bytes((0xF0, 0x09, 1))))  # GBS on
    rig.say(ubx(6, MSG, bytes((0xF0, 0x09, 0))))  # off is fine
    rig.say(ubx(0x02, 0x41, bytes(8)))
    rig.say(nmea("PUBX,41,1,0007,0003,9600,1"))
    reports = [str(report) for report in rig.chip.reports]
    assert len(reports) == 4
    assert reports[0].endswith("not modelled: CFG 0x16: this configuration message is not modelled (3 times)")
    assert "0xF009" in reports[1]
    assert "UBX 0x0241" in reports[2]
    assert "automatic baud detection" in reports[3]
    answers = ubx_messages(rig.run(0.5))
    assert identities(answers) == ["ACK-NAK"] * 4 + ["ACK-ACK"]


def test_strict_mode_raises_instead() -> None:
    rig = Rig(strict=True)
    rig.run(0.5)
    with pytest.raises(RuntimeError, match="CFG 0x16"):
        rig.say(ubx(6, 0x16, bytes(8)))


def test_message_rates_for_one_port_and_for_all(rig: Rig) -> None:
    rig.say(PVT_ON)
    rig.run(0.2)
    assert identities(ubx_messages(rig.run(1.0))) == ["NAV-PVT"]
    rig.say(ubx(6, MSG, bytes.fromhex("0107 000000000000")))
    rig.say(ubx(6, MSG, bytes.fromhex("f004 000100000000")))
    rig.run(0.2)
    data = rig.run(1.0)
    assert [text[3:6] for text in lines(data)] == ["RMC"]


def test_every_periodic_message_parses_and_agrees(rig: Rig) -> None:
    rig.say(ubx(6, PRT, bytes.fromhex("01000000d0080000000e0e000700030000000000")))
    rig.run(0.3)
    ids = (0x01, 0x02, 0x03, 0x04, 0x06, 0x07, 0x11, 0x12, 0x20, 0x21, 0x22, 0x26, 0x30, 0x35, 0x61)
    for message_id in ids:
        rig.say(ubx(6, MSG, bytes((1, message_id, 1))))
    rig.say(ubx(6, MSG, bytes((0x0A, 0x09, 1))))
    rig.run_to((rig.time.now // SECOND + 1) * SECOND)
    messages = {m.identity: m for m in ubx_messages(rig.run(0.9))}
    assert len(messages) == len(ids) + 1
    pvt = messages["NAV-PVT"]
    assert len({m.iTOW for name, m in messages.items() if name.startswith("NAV")}) == 1
    assert (pvt.lon, pvt.lat) == (messages["NAV-POSLLH"].lon, messages["NAV-POSLLH"].lat)
    assert (pvt.height, pvt.hMSL, pvt.hAcc, pvt.vAcc) == (135_500, 87_400, 1200, 2040)
    assert (pvt.velN, pvt.velE, pvt.velD, pvt.gSpeed, pvt.sAcc) == (3000, 4000, -250, 5000, 120)
    assert pvt.headMot == pytest.approx(53.1301, abs=1e-4)
    assert (messages["NAV-VELNED"].speed, messages["NAV-VELNED"].gSpeed) == (501, 500)
    assert (messages["NAV-DOP"].pDOP, messages["NAV-DOP"].tDOP) == (1.56, 0.9)
    assert messages["NAV-DOP"].gDOP == pytest.approx(1.80, abs=0.01)
    assert (messages["NAV-TIMEGPS"].week, messages["NAV-TIMEGPS"].leapS) == (2305, 18)
    leap = messages["NAV-TIMELS"]
    assert (leap.srcOfCurrLs, leap.currLs, leap.validCurrLs, leap.validTimeToLsEvent) == (1, 18, 1, 0)
    assert messages["NAV-SAT"].numSvs == messages["NAV-SVINFO"].numCh == 9
    assert (messages["NAV-SVINFO"].svid_07, messages["NAV-SAT"].svId_08) == (133, 3)  # SBAS 46, GLONASS 67
    sol = messages["NAV-SOL"]
    # Closed form for 50.5020575°, −4.2590535°, 135.5 m on WGS-84 (cm).
    assert (sol.ecefX, sol.ecefY, sol.ecefZ) == (405_378_749, -30_189_255, 489_860_270)
    speed = (sol.ecefVX**2 + sol.ecefVY**2 + sol.ecefVZ**2) ** 0.5
    assert speed == pytest.approx(500.6, abs=1.5)
    place, velocity = messages["NAV-POSECEF"], messages["NAV-VELECEF"]
    assert (place.ecefX, place.ecefY, place.ecefZ, place.pAcc) == (sol.ecefX, sol.ecefY, sol.ecefZ, sol.pAcc)
    assert (velocity.ecefVX, velocity.ecefVY, velocity.ecefVZ) == (sol.ecefVX, sol.ecefVY, sol.ecefVZ)


def test_leap_seconds_by_default_until_they_are_known() -> None:
    rig = Rig(start_state="cold", default_leap_seconds=16)
    rig.run(22.0)
    (before,) = rig.ask(ubx(1, 0x26))
    assert (before.identity, before.length) == ("NAV-TIMELS", 24)
    assert (before.srcOfCurrLs, before.currLs, before.validCurrLs) == (0, 16, 0)
    rig.run(8.0)
    (after,) = rig.ask(ubx(1, 0x26))
    assert (after.srcOfCurrLs, after.currLs, after.validCurrLs) == (1, 18, 1)


def test_end_of_epoch_comes_behind_everything(rig: Rig) -> None:
    for message in ("016101", "010701", "f00401"):
        rig.say(ubx(6, MSG, bytes.fromhex(message)))
    rig.run_to((rig.time.now // SECOND + 1) * SECOND)
    told = rig.run(0.9)
    assert told.index(b"\xb5b\x01\x07") < told.index(b"RMC") < told.index(b"\xb5b\x01\x61")


def test_poll_of_any_message_answers_with_the_newest_solution(rig: Rig) -> None:
    assert identities(rig.ask(ubx(1, 0x12))) == ["NAV-VELNED"]
    rig.say(ubx(0xF0, 0x00))
    assert [text[3:6] for text in lines(rig.run(0.5))] == ["GGA"]
    rig.say(nmea("EIGNQ,RMC"))
    assert line(rig.run(0.5), "RMC")


def test_pubx_polls(rig: Rig) -> None:
    rig.say(b"$PUBX,00*33\r\n$PUBX,03*30\r\n$PUBX,04*37\r\n")
    heard = rig.run(0.9)
    printed = lines(heard)
    assert [message.msgId for message in nmea_messages(heard)] == ["00", "03", "04"]
    assert printed[0][:-3] == (
        "$PUBX,00,092729.00,5030.12345,N,00415.54321,W,135.500,G3,1.2,2.0,18.000,53.13,-0.250,,0.95,1.27,0.90,5,0,0"
    )
    assert printed[1].startswith(
        "$PUBX,03,9,1,U,280,53,36,004,3,U,301,29,24,004,4,U,223,55,37,004,8,e,166,38,16,004,"
    )
    assert ",12,-,034,05,,000,133,-,156,43,,000,67,U,349,62,26,004,84,-,353,01,,000*" in printed[1]
    assert printed[2].startswith("$PUBX,04,092729.00,150324,466049.00,2305,18,")


def test_pubx_without_a_fix() -> None:
    rig = Rig(start_state="cold")
    rig.run(1.6)
    rig.say(b"$PUBX,00*33\r\n$PUBX,04*37\r\n")
    printed = lines(rig.run(0.3))[-2:]
    assert printed[0].startswith(
        "$PUBX,00,,0000.00000,N,00000.00000,E,0.000,NF,5303302,3750001,0.000,0.00,0.000,,99.99,"
    )
    assert printed[1].startswith("$PUBX,04,,,,,18D,")


def test_pubx_40_sets_rates(rig: Rig) -> None:
    rig.say(nmea("PUBX,40,ZDA,0,1,0,0,0,0"))
    rig.run(0.2)
    assert [text[3:6] for text in lines(rig.run(1.0))] == ["ZDA"]
    rig.say(nmea("PUBX,40,ZDA,0,0,0,0,0,0"))
    rig.run(0.2)
    assert rig.run(1.0) == b""


def test_pubx_periodic_by_cfg_msg(rig: Rig) -> None:
    for message_id in (0, 3, 4):
        rig.say(ubx(6, MSG, bytes((0xF1, message_id, 1))))
    rig.run(0.5)
    assert [text[:8] for text in lines(rig.run(1.0))] == ["$PUBX,00", "$PUBX,03", "$PUBX,04"]


@pytest.mark.parametrize(
    "text",
    [
        "PUBX,41,1,0007,0003,12",
        "PUBX,41,9,0007,0003,9600,0",
        "PUBX,41,1,00 7,0003,9600,0",
        "PUBX,40,GLL,1,x,0,0,0,0",
    ],
)
def test_wrong_pubx_commands_change_nothing(rig: Rig, text: str) -> None:
    rig.say(nmea(text))
    assert rig.run(0.9) == b""
    assert rig.chip.baud == 9600
    assert len(rig.chip.reports) == 1


def test_sentences_with_a_wrong_checksum_are_ignored_and_unknown_ones_answered(rig: Rig) -> None:
    rig.say(b"$PUBX,00*34\r\n$PUBX,00\r\n$PUBX,00*3\r\n$PUBX,00*GG\r\n")
    assert rig.run(0.5) == b""
    rig.say(nmea("PMTK220,200"))
    assert rig.run(0.5) == b"$GNTXT,01,01,01,NMEA unknown msg*46\r\n"


def test_input_protocol_mask(rig: Rig) -> None:
    rig.say(ubx(6, PRT, bytes.fromhex("01000000d0080000802500000100030000000000")))  # UBX in only
    rig.run(0.5)
    rig.say(b"$PUBX,00*33\r\n")
    assert rig.run(0.5) == b""
    rig.say(nmea("PUBX,41,1,0002,0003,9600,0"))
    assert identities(rig.ask(ubx(6, RATE))) == ["CFG-RATE", "ACK-ACK"]
    rig.say(ubx(6, PRT, bytes.fromhex("01000000d0080000802500000200030000000000")))  # NMEA in only
    assert identities(ubx_messages(rig.run(0.5))) == ["ACK-ACK"]
    assert rig.ask(ubx(6, RATE)) == []
    rig.say(b"$PUBX,00*33\r\n")
    assert rig.run(0.5).startswith(b"$PUBX,00")


def test_output_protocol_mask_takes_effect_after_the_acknowledgement() -> None:
    rig = Rig()
    rig.run(2.9)
    rig.say(ubx(6, PRT, bytes.fromhex("01000000d0080000802500000700010000000000")))  # UBX out only
    assert rig.run(2.0) == ubx(5, 1, b"\x06\x00")
    rig.say(ubx(6, PRT, bytes.fromhex("01000000d0080000802500000700020000000000")))  # NMEA out only
    data = rig.run(1.0)
    assert data.startswith(ubx(5, 1, b"\x06\x00"))
    assert b"$GNRMC" in data
    rig.run(0.8)
    rig.say(ubx(6, RATE))
    assert b"\xb5" not in rig.run(1.0)


def test_nav5_applies_only_what_its_mask_chooses(rig: Rig) -> None:
    rig.say(ubx(6, NAV5, bytes.fromhex("0100 04 01") + bytes(32)))  # dynamic model only
    messages = rig.ask(ubx(6, NAV5))
    (nav5,) = [message for message in messages if message.identity == "CFG-NAV5"]
    assert (nav5.dynModel, nav5.fixMode, nav5.minElev) == (4, 3, 5)
    rig.say(ubx(6, NAV5, bytes.fromhex("0400 00 01") + bytes(32)))  # 2D only
    rig.say(ubx(6, MSG, bytes((0xF0, 0x02, 1))))
    rig.run(0.5)
    assert line(rig.run(1.0), "GSA").startswith("$GNGSA,M,2,")


def test_cfg_inf_switches_texts(rig: Rig) -> None:
    rig.say(ubx(6, INF, bytes.fromhex("01000000 000000000000")))
    rig.run(0.3)
    rig.say(nmea("PMTK220,200"))
    assert rig.run(0.5) == b""
    rig.say(ubx(6, INF, bytes.fromhex("00000000 070707070707")))
    rig.run(0.3)
    rig.say(nmea("PMTK220,200"))
    (text,) = ubx_messages(rig.run(0.5))
    assert text.identity == "INF-WARNING"


def test_switching_systems_counts_their_satellites_only(rig: Rig) -> None:
    rig.say(ubx(6, GNSS, bytes.fromhex("00202001 06080e0000000101")))
    rig.run(2.5)
    pvt = [m for m in rig.ask(ubx(1, 7)) if m.identity == "NAV-PVT"][-1]
    assert (pvt.fixType, pvt.numSV) == (3, 4)
    rig.say(ubx(6, GNSS, bytes.fromhex("00202002 0008100000000101 06080e0001000101")))  # GLONASS only: one
    rig.run(2.5)
    pvt = [m for m in rig.ask(ubx(1, 7)) if m.identity == "NAV-PVT"][-1]
    assert (pvt.fixType, pvt.numSV) == (0, 0)


def test_switching_systems_does_not_hasten_a_cold_start() -> None:
    rig = Rig(start_state="cold")
    rig.run(1.9)
    rig.say(ubx(6, GNSS, bytes.fromhex("00202001 06080e0000000101")))
    assert b"RMC,,V" in rig.run(18.0)[-400:]
