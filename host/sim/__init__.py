"""The sensor simulator: trajectory, inertial sensor errors, GNSS and recordings as one world."""
