"""Scenarios that come with the simulator, for any board and none."""

from pathlib import Path

DRIVES = Path(__file__).parent
