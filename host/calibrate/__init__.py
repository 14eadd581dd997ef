"""Calibration of a board by its own firmware, on a simulated table."""
