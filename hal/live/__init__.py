"""The interfaces of `hal` in real time, on real links.

    LiveCpu            clock, interrupts and sleep of a program that is a thread of this computer
    LiveUart           any port that pyserial opens, over a link that survives unplugging
    LiveCan            any bus that python-can opens
    BusPirate…         SPI and I²C through a serial bridge
    LiveTimer, LiveCapture, ModemInput, ModemOutput, LiveLogFile, LiveWatchdog

Set-up (opening a port, entering the bridge's modes) raises exceptions whose message says what to do.
Afterwards firmware meets nothing that a chip would not show it: a port that has vanished is silent, a bridge
that has gone reads as an SPI line without a slave, or as BusError on I²C. What really happened stands in
the counters of the link.
"""
