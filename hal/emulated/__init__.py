"""The interfaces of `hal` on virtual time."""
