"""What firmware may touch: one bus, one file, one required method.

The modules here hold interfaces only. `hal.emulated` puts them on virtual time, `hal.scripted` on a
written transcript for driver tests; firmware imports neither.
"""
