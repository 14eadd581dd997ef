"""Arithmetic of a processor without floating point: 32-bit numbers in Q formats, 64-bit products."""
