"""The registers of the fact sheet's section 3 as data: two bytes each, the low one at the even address."""

from __future__ import annotations

from boards.chips.registers import Access, Register

FLASH_CNT = 0x00
SUPPLY_OUT, AUX_ADC = 0x02, 0x1C
GYRO_OFF, ACCL_OFF, MAGN_HIC, MAGN_SIC = 0x1E, 0x24, 0x2A, 0x30
"""The x axis; y and z follow."""
GPIO_CTRL, MSC_CTRL, SMPL_PRD, SENS_AVG, SLP_CTRL = 0x36, 0x38, 0x3A, 0x3C, 0x3E
DIAG_STAT, GLOB_CMD = 0x40, 0x42
ALM_MAG1, ALM_MAG2, ALM_SMPL1, ALM_SMPL2, ALM_CTRL = 0x44, 0x46, 0x48, 0x4A, 0x4C
AUX_DAC = 0x4E
LOT_ID1, LOT_ID2, PROD_ID, SERIAL_NUM = 0x52, 0x54, 0x56, 0x58

OUTPUTS = tuple(range(SUPPLY_OUT, AUX_ADC + 2, 2))
"""In the order of a burst."""
USER_CALIBRATION = range(GYRO_OFF, GPIO_CTRL)

_R, _RW, _W = Access.READ, Access.READ_WRITE, Access.WRITE
_OUTPUT_NAMES = (
    "SUPPLY_OUT", "XGYRO_OUT", "YGYRO_OUT", "ZGYRO_OUT", "XACCL_OUT", "YACCL_OUT", "ZACCL_OUT",
    "XMAGN_OUT", "YMAGN_OUT", "ZMAGN_OUT", "BARO_OUT", "BARO_OUTL", "TEMP_OUT", "AUX_ADC",
)  # fmt: skip

# name, address, access, reset, bits without a meaning
_WORDS: tuple[tuple[str, int, Access, int, int], ...] = (
    ("FLASH_CNT", FLASH_CNT, _R, 0, 0),
    *((name, address, _R, 0, 0) for name, address in zip(_OUTPUT_NAMES, OUTPUTS, strict=True)),
    *((f"{axis}GYRO_OFF", GYRO_OFF + 2 * k, _RW, 0, 0) for k, axis in enumerate("XYZ")),
    *((f"{axis}ACCL_OFF", ACCL_OFF + 2 * k, _RW, 0, 0) for k, axis in enumerate("XYZ")),
    *((f"{axis}MAGN_HIC", MAGN_HIC + 2 * k, _RW, 0, 0) for k, axis in enumerate("XYZ")),
    *((f"{axis}MAGN_SIC", MAGN_SIC + 2 * k, _RW, 0x0800, 0xF000) for k, axis in enumerate("XYZ")),
    ("GPIO_CTRL", GPIO_CTRL, _RW, 0, 0xF0F0),
    ("MSC_CTRL", MSC_CTRL, _RW, 0x0006, 0xF038),
    ("SMPL_PRD", SMPL_PRD, _RW, 0x0001, 0xFF00),
    ("SENS_AVG", SENS_AVG, _RW, 0x0402, 0xF8F8),
    ("SLP_CTRL", SLP_CTRL, _RW, 0, 0xFE00),
    ("DIAG_STAT", DIAG_STAT, _R, 0, 0),
    ("GLOB_CMD", GLOB_CMD, _W, 0, 0xFF60),
    ("ALM_MAG1", ALM_MAG1, _RW, 0, 0),
    ("ALM_MAG2", ALM_MAG2, _RW, 0, 0),
    ("ALM_SMPL1", ALM_SMPL1, _RW, 0, 0xFF00),
    ("ALM_SMPL2", ALM_SMPL2, _RW, 0, 0xFF00),
    ("ALM_CTRL", ALM_CTRL, _RW, 0, 0x0028),
    ("AUX_DAC", AUX_DAC, _RW, 0, 0xF000),
    ("LOT_ID1", LOT_ID1, _R, 0, 0),
    ("LOT_ID2", LOT_ID2, _R, 0, 0),
    ("PROD_ID", PROD_ID, _R, 0x4017, 0),
    ("SERIAL_NUM", SERIAL_NUM, _R, 0, 0),
)


def _bytes_of(
    name: str, address: int, access: Access, reset: int, reserved: int
) -> tuple[Register, Register]:
    low = Register(address, name, access, reset & 0xFF, reserved & 0xFF)
    return low, Register(address + 1, name, access, reset >> 8, reserved >> 8)


REGISTERS = tuple(register for word in _WORDS for register in _bytes_of(*word))

SIGN_BYTES = {
    **{GYRO_OFF + 2 * k + 1: 0x1F for k in range(3)},
    **{ACCL_OFF + 2 * k + 1: 0x0F for k in range(3)},
    **{MAGN_HIC + 2 * k + 1: 0x3F for k in range(3)},
}
"""High bytes of signed numbers: the bits that are kept. A driver may write the sign into the rest."""

SAVED = tuple(address for name, address, access, *_ in _WORDS if access is _RW and address != SLP_CTRL)
"""What goes into the flash."""
