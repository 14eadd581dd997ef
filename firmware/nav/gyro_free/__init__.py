"""Navigation without gyroscopes: angular rate from nine accelerometers, and filters side by side."""
