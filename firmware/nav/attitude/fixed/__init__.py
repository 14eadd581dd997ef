"""The attitude computer in fixed point: no floating-point number anywhere in the loop."""
