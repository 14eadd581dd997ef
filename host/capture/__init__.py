"""Captures: one MCAP file holds a run's raw bus traffic, solution, truth, events and manifest."""
