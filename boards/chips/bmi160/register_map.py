"""The BMI160's registers as data (fact sheet section 3) and their named bits.

Where sources conflict the fact sheet's own value stands. Reserved bits follow the field lists there; tags
name what this model leaves out. docs/fidelity/bmi160.md tells why.
"""

from __future__ import annotations

from boards.chips.registers import Access, NotModelled, Register

CHIP_ID, ERR_REG, PMU_STATUS = 0x00, 0x02, 0x03
MAG_DATA, GYR_DATA, ACC_DATA, SENSORTIME = 0x04, 0x0C, 0x12, 0x18
STATUS, INT_STATUS_0, TEMPERATURE, FIFO_LENGTH, FIFO_DATA = 0x1B, 0x1C, 0x20, 0x22, 0x24
ACC_CONF, ACC_RANGE, GYR_CONF, GYR_RANGE, MAG_CONF = 0x40, 0x41, 0x42, 0x43, 0x44
FIFO_DOWNS, FIFO_CONFIG_0, FIFO_CONFIG_1 = 0x45, 0x46, 0x47
INT_EN_0, INT_OUT_CTRL, INT_LATCH = 0x50, 0x53, 0x54
INT_MAP_0, INT_MAP_1, INT_MAP_2 = 0x55, 0x56, 0x57
INT_DATA_0, INT_DATA_1, INT_LOWHIGH_0, INT_MOTION_0 = 0x58, 0x59, 0x5A, 0x5F
FOC_CONF, CONF, IF_CONF, SELF_TEST = 0x69, 0x6A, 0x6B, 0x6D
NV_CONF, OFFSET_0, OFFSET_6 = 0x70, 0x71, 0x77
CMD, DUMMY = 0x7E, 0x7F

DRDY_ACC, DRDY_GYR, NVM_RDY, FOC_RDY, GYR_SELF_TEST_OK = 0x80, 0x40, 0x10, 0x08, 0x02
"""Bits of STATUS."""

NVM_REGISTERS = range(NV_CONF, OFFSET_6 + 1)
"""Registers whose reset values come from the non-volatile memory."""

_R, _RW, _W = Access.READ, Access.READ_WRITE, Access.WRITE
_SECONDARY = "secondary interface (magnetometer, OIS)"


def _feature(mask: int, reason: str) -> NotModelled:
    return NotModelled(mask, reason)


_SECONDARY_WRITE = (NotModelled(0xFF, _SECONDARY, any_write=True),)

REGISTERS: tuple[Register, ...] = (
    Register(CHIP_ID, "CHIP_ID", _R, 0xD1),
    Register(ERR_REG, "ERR_REG", _R),
    Register(PMU_STATUS, "PMU_STATUS", _R),
    *(Register(MAG_DATA + i, f"MAG_DATA_{i}", _R) for i in range(8)),
    *(Register(GYR_DATA + i, f"GYR_DATA_{i}", _R) for i in range(6)),
    *(Register(ACC_DATA + i, f"ACC_DATA_{i}", _R) for i in range(6)),
    *(Register(SENSORTIME + i, f"SENSORTIME_{i}", _R) for i in range(3)),
    Register(STATUS, "STATUS", _R, 0x01),
    *(Register(INT_STATUS_0 + i, f"INT_STATUS_{i}", _R) for i in range(4)),
    *(Register(TEMPERATURE + i, f"TEMPERATURE_{i}", _R) for i in range(2)),
    *(Register(FIFO_LENGTH + i, f"FIFO_LENGTH_{i}", _R) for i in range(2)),
    Register(FIFO_DATA, "FIFO_DATA", _R),
    Register(ACC_CONF, "ACC_CONF", _RW, 0x28),
    Register(ACC_RANGE, "ACC_RANGE", _RW, 0x03, reserved=0xF0),
    Register(GYR_CONF, "GYR_CONF", _RW, 0x28, reserved=0xC0),
    Register(GYR_RANGE, "GYR_RANGE", _RW, 0x00, reserved=0xF8),
    Register(MAG_CONF, "MAG_CONF", _RW, 0x0B, reserved=0xF0),
    Register(FIFO_DOWNS, "FIFO_DOWNS", _RW, 0x88),
    Register(FIFO_CONFIG_0, "FIFO_CONFIG_0", _RW, 0x80),
    Register(
        FIFO_CONFIG_1, "FIFO_CONFIG_1", _RW, 0x10, reserved=0x01, not_modelled=(_feature(0x20, _SECONDARY),)
    ),
    Register(0x4B, "MAG_IF_0", _RW, 0x20, reserved=0x01, not_modelled=_SECONDARY_WRITE),
    Register(0x4C, "MAG_IF_1", _RW, 0x80, reserved=0x40, not_modelled=_SECONDARY_WRITE),
    Register(0x4D, "MAG_IF_2", _RW, 0x42, not_modelled=_SECONDARY_WRITE),
    Register(0x4E, "MAG_IF_3", _RW, 0x4C, not_modelled=_SECONDARY_WRITE),
    Register(0x4F, "MAG_IF_4", _RW, 0x00, not_modelled=_SECONDARY_WRITE),
    Register(
        INT_EN_0,
        "INT_EN_0",
        _RW,
        reserved=0x08,
        not_modelled=(
            _feature(0x80, "flat interrupt"),
            _feature(0x40, "orientation interrupt"),
            _feature(0x30, "tap interrupts"),
        ),
    ),
    Register(0x51, "INT_EN_1", _RW, reserved=0x80),
    Register(0x52, "INT_EN_2", _RW, reserved=0xF0, not_modelled=(_feature(0x08, "step detector"),)),
    Register(INT_OUT_CTRL, "INT_OUT_CTRL", _RW),
    Register(INT_LATCH, "INT_LATCH", _RW, reserved=0xC0),
    Register(INT_MAP_0, "INT_MAP_0", _RW),
    Register(INT_MAP_1, "INT_MAP_1", _RW),
    Register(INT_MAP_2, "INT_MAP_2", _RW),
    Register(
        INT_DATA_0,
        "INT_DATA_0",
        _RW,
        reserved=0x77,
        not_modelled=(_feature(0x88, "unfiltered interrupt data"),),
    ),
    Register(
        INT_DATA_1,
        "INT_DATA_1",
        _RW,
        reserved=0x7F,
        not_modelled=(_feature(0x80, "unfiltered interrupt data"),),
    ),
    Register(INT_LOWHIGH_0, "INT_LOWHIGH_0", _RW, 0x07),
    Register(0x5B, "INT_LOWHIGH_1", _RW, 0x30),
    Register(0x5C, "INT_LOWHIGH_2", _RW, 0x81, reserved=0x38),
    Register(0x5D, "INT_LOWHIGH_3", _RW, 0x0B),
    Register(0x5E, "INT_LOWHIGH_4", _RW, 0xC0),
    Register(INT_MOTION_0, "INT_MOTION_0", _RW, 0x00),
    Register(0x60, "INT_MOTION_1", _RW, 0x14),
    Register(0x61, "INT_MOTION_2", _RW, 0x14),
    Register(
        0x62, "INT_MOTION_3", _RW, 0x24, reserved=0xC0, not_modelled=(_feature(0x02, "significant motion"),)
    ),
    Register(0x63, "INT_TAP_0", _RW, 0x04, reserved=0x38),
    Register(0x64, "INT_TAP_1", _RW, 0x0A, reserved=0xE0),
    Register(0x65, "INT_ORIENT_0", _RW, 0x18),
    Register(0x66, "INT_ORIENT_1", _RW, 0x48),
    Register(0x67, "INT_FLAT_0", _RW, 0x08, reserved=0xC0),
    Register(0x68, "INT_FLAT_1", _RW, 0x11, reserved=0xC8),
    Register(FOC_CONF, "FOC_CONF", _RW, reserved=0x80),
    Register(CONF, "CONF", _RW, reserved=0xFD),
    Register(IF_CONF, "IF_CONF", _RW, reserved=0xCE, not_modelled=(_feature(0x30, _SECONDARY),)),
    Register(
        0x6C, "PMU_TRIGGER", _RW, reserved=0x80, not_modelled=(_feature(0x7F, "automatic PMU trigger"),)
    ),
    Register(SELF_TEST, "SELF_TEST", _RW, reserved=0xE0),
    Register(NV_CONF, "NV_CONF", _RW, reserved=0xF0, not_modelled=(_feature(0x04, "I2C watchdog"),)),
    *(Register(OFFSET_0 + i, f"OFFSET_{i}", _RW) for i in range(7)),
    Register(0x78, "STEP_CNT_0", _R),
    Register(0x79, "STEP_CNT_1", _R),
    Register(0x7A, "STEP_CONF_0", _RW, 0x15),
    Register(0x7B, "STEP_CONF_1", _RW, 0x03, reserved=0xF0, not_modelled=(_feature(0x08, "step counter"),)),
    Register(CMD, "CMD", _W),
    Register(DUMMY, "DUMMY", _R),
)
