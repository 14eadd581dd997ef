"""Processor in the loop: the kernels of a board as a Cortex-M4F computes them, compared with the twin's."""
