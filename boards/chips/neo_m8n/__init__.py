"""u-blox NEO-M8N GNSS receiver on its UART, with time pulse output.

`NeoM8n` is the chip: `receive(data, time_ns)` takes bytes from the host, the wire given as `tx` carries
what it says, `pins["TIMEPULSE"]` is an output net, `power(on)` its supply.
"""

from boards.chips.neo_m8n.receiver import NeoM8n

__all__ = ["NeoM8n"]
