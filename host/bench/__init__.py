"""The benchmark behind `make bench`: speed as × real time, where the microseconds go, start-up, memory."""
