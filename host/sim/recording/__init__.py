"""Real recordings behind the same world faces as the simulation."""
