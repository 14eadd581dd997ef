"""The drift compensation in fixed point, for a constant sample period."""
