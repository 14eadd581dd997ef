"""What goes over the I²C bus between the processors. The DSP is the master, the FPGA answers at ADDRESS.

write   ALIGNED, then yaw, pitch, roll (signed tenths of a degree, high byte first)
        PRESENT alone, once a second in settings mode: the DSP is there
read    STATUS: mark, starts of the FPGA, chips missing, stuck, at odds with the others (bits each), compass,
        receiver, errors of its port, packets not sent since the one before was under way (16 bits)
"""

from __future__ import annotations

from struct import Struct
from typing import Final

ADDRESS: Final = 0x2A
ALIGNED: Final = 0x10
RESULT: Final = Struct(">B3h")
STATUS: Final = Struct(">8BH")
MARK: Final = 0x47
SETTINGS_MARK: Final = 0x53
"""The mark in settings mode."""
PRESENT: Final = 0x11
BYTE: Final = 0xFF
