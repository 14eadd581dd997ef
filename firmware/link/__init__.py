"""What leaves the board: frames to the host, NMEA sentences of our own solution, CAN messages."""
