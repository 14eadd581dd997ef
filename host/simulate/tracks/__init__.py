"""Trajectories from files: CSV, GPX, KML, NMEA logs, NPZ and captures, read into one form and checked."""
