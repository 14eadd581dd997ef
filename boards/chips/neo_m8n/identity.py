"""Who the receiver says it is: start-up texts, MON-VER, MON-HW (fact sheet sections 1 and 4).

Strings of a NEO-M8N with flash firmware SPG 3.01, protocol version 18.00, as public start-up logs and
MON-VER dumps show them. MON-HW is a constant picture of a healthy receiver with its antenna connected.
"""

from struct import Struct

from boards.chips.neo_m8n.ubx import CLASS_MON, frame

SOFTWARE = b"EXT CORE 3.01 (111141)"
HARDWARE = b"00080000"
EXTENSIONS = (
    b"ROM BASE 2.01 (75331)",
    b"FWVER=SPG 3.01",
    b"PROTVER=18.00",
    b"MOD=NEO-M8N-0",
    b"FIS=0xEF4015 (100111)",
    b"GPS;GLO;GAL;BDS",
    b"SBAS;IMES;QZSS",
)
START_UP_TEXTS = (
    b"u-blox AG - www.u-blox.com",
    b"HW UBX-M8030 " + HARDWARE,
    SOFTWARE,
    *EXTENSIONS,
    b"GNSS OTP=GPS;GLO",
    b"LLC=FFFFFFFF-FFFFFFFF-FFFFFFFF-FFFFFFFF-FFFFFFFD",
    b"ANTSUPERV=AC SD PDoS SR",
    b"ANTSTATUS=OK",
    b"PF=3FF",
)

_HW = Struct("<4I2H4BI17sBH3I")
NOISE_LEVEL = 90
AGC_COUNT = 5000
ANTENNA_OK = 2
ANTENNA_POWERED = 1
RTC_CALIBRATED = 0x01
VIRTUAL_PINS = bytes((11, 16, 15, 1, 2, 3, 4, 30, 31, 8, 17, 255, 255, 255, 18, 19, 25))


def mon_ver() -> bytes:
    """0A 04: software (30 bytes), hardware (10), extensions (30 each), padded with zeros."""
    payload = SOFTWARE.ljust(30, b"\0") + HARDWARE.ljust(10, b"\0")
    return frame(CLASS_MON, 0x04, payload + b"".join(text.ljust(30, b"\0") for text in EXTENSIONS))


def mon_hw() -> bytes:
    """0A 09: hardware status."""
    payload = _HW.pack(
        *(0x0001_F000, 0, 0x0001_0000, 0x0001_EF9F, NOISE_LEVEL, AGC_COUNT, ANTENNA_OK, ANTENNA_POWERED),
        *(RTC_CALIBRATED, 0, 0x0000_EBFF, VIRTUAL_PINS, 10, 0, 0, 0x0001_EB67, 0),
    )
    return frame(CLASS_MON, 0x09, payload)
