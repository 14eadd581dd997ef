"""A GNSS receiver's solutions: errors, outages and the sky above it."""
