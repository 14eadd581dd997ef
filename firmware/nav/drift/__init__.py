"""Drift compensation: an attitude held by gyros, levelled by accelerometers, turned by a magnetometer."""
