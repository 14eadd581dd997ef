"""What would be flashed: numerics, navigation, drivers, the link, and one program per processor."""

from hal import engine

engine.use()
