"""Boards: chip models, board descriptions, and the assembly that puts them together on virtual time."""

from hal import engine

engine.use()
