"""What lies where in the memory between FPGA and DSP, and what the two mailboxes say. Words of 32 bits.

| from word | what | written by |
| --- | --- | --- |
| 0 | ring of 8 samples, 10 × int64 each (`firmware.drivers.serial_imu_frames`) | FPGA |
| 160 | ring of 2 epochs, 32 × int64 each (`firmware.drivers.gnss_epoch`) | FPGA |
| 320 | health of the front end (`HEALTH`) | FPGA |
| 352 | words of the output ring that have been taken, modulo 2³² | FPGA |
| 2048 | ring of output: for each piece its length in bytes, then its bytes in whole words | DSP |

Times are of the FPGA's clock, which is the board's. The FPGA's word in the DSP's mailbox: samples so far
(16 bits), epochs so far (8), starts of the FPGA (8). The DSP's in the FPGA's: words of output so far.
"""

from __future__ import annotations

from struct import Struct
from typing import Final

from firmware.drivers.gnss_epoch import RECORD_SIZE
from firmware.drivers.serial_imu_frames import SAMPLE_SIZE
from hal.dual_port import DualPortMemory

WORD: Final = 4
SAMPLE_WORDS: Final = 2 * SAMPLE_SIZE
SAMPLES: Final = 8
EPOCHS_AT: Final = 160
EPOCH_WORDS: Final = 2 * RECORD_SIZE
EPOCHS: Final = 2
HEALTH_AT: Final = 320
TAKEN_AT: Final = 352
OUTPUT_AT: Final = 2048
OUTPUT_WORDS: Final = 2048
LONGEST_PIECE: Final = 4096
"""Bytes."""

HEALTH: Final = Struct("<Q11I4x")
"""Clock in ns, starts, frames, lost samples, bad frames, garbage, overruns and errors of the unit's line;
phase of the receiver's set-up (and in bit 8 whether the pulse dated the last epoch), its bad check sums,
garbage and errors of its port."""
HEALTH_WORDS: Final = HEALTH.size // WORD
PHASE_MASK: Final = 0xFF
PULSE_DATED: Final = 0x100

COUNT_MASK: Final = 0xFFFF
EPOCH_SHIFT, START_SHIFT = 16, 24
BYTE: Final = 0xFF
WORD_MASK: Final = 0xFFFF_FFFF


def check_memory(memory: DualPortMemory) -> None:
    """Raises ValueError for a memory that the map does not fit."""
    needed = OUTPUT_AT + OUTPUT_WORDS
    if memory.words < needed or memory.word_bytes != WORD:
        raise ValueError(
            f"the memory 'exchange' has {memory.words} words of {8 * memory.word_bytes} bits; the programs of"
            f" this board need {needed} of {8 * WORD}: interconnects.exchange.words = {needed}"
        )


def words_of(length: int) -> int:
    """Words of a piece of output of so many bytes, with its length."""
    return 1 + (length + WORD - 1) // WORD
