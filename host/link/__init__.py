"""The PC end of the host link: bytes back to typed frames."""
