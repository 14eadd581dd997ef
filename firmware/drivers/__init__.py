"""Device drivers: identify, configure, read, pure conversion. One attempt per call, results instead of
exceptions, every wait with its cause, its bound and the section of the fact sheet that asks for it."""
