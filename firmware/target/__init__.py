"""The small part of the image that is not Python: start-up, serial port, monitor."""
