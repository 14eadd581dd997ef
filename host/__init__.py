"""The PC side: command line, simulation, recording, scoring and reports."""
