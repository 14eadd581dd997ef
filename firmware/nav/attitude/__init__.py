"""Attitude, velocity and position of a small aircraft from three samples an iteration."""
