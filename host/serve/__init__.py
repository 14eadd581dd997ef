"""A board under virtual time, served to the world outside: serial lines, CAN, control, at any pace."""
