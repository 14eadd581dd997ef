"""Errors of inertial sensors: presets, processes and the sensor as its chip model sees it."""
