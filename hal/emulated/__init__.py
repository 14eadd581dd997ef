"""The interfaces of `hal` on virtual time."""

from hal import engine

engine.use()
