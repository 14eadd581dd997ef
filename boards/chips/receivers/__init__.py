"""What receivers have in common: supply and start, the serial port, sentences in and out, UTC."""
