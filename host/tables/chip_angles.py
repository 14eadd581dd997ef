"""Rows of the angle tables measured by the whole board."""

from __future__ import annotations

from host.record.errors import UserError
from host.tables.angle_rows import CHIP, AngleRow, scored
from host.tables.board_run import STILL_S, run_board, sensor
from host.tables.document import DocumentRow
from host.tables.positions import HOLD_S, motion_s, position_scenario


def chip_row(document: DocumentRow, arithmetic: str, seed: int, compensated: bool) -> AngleRow:
    """One position in one arithmetic. Raises UserError."""
    scenario = position_scenario(document.axis, document.angle_deg, STILL_S, imu=sensor())
    told = run_board(scenario, arithmetic, seed, drift_compensation=compensated)
    held = told.after(STILL_S + motion_s(document.angle_deg))
    if not len(held.times_s):
        raise UserError(f"{scenario.name}: the board told no solution within the {HOLD_S:g} s of rest")
    return scored(document, (CHIP, arithmetic, compensated), held.measured, held.truth)
