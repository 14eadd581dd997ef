"""Figures that were good once, kept in a file beside the sources, and what has become worse since."""
