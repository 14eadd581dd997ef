"""Motion of the vehicle: segments, road sway and vibration, and their exact kinematics."""
