"""How firmware ends, other than by its own will. None of these is an error that firmware may handle."""


class SpinError(RuntimeError):
    """The firmware waits in a loop for something that does not come."""


class PowerOff(BaseException):
    """Unwinds the firmware when the run ends. Firmware must not catch BaseException."""


class ProcessorReset(BaseException):
    """Unwinds the firmware to its reset vector."""
