"""Boards: chip models, and one folder per board with its description."""
