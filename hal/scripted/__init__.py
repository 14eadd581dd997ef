"""The interfaces of `hal` on a written transcript, for tests of drivers.

    # who am I, then two data bytes
    spi imu 80 .. -> 00 d1
    delay 1000000
    <- line imu_ready
    spi imu 92 .. .. -> 00 34 12

A transcript says what the driver must do, in order, and what it gets for it; `Transcript` tells the format.
The first thing that differs raises an AssertionError that shows both sides; so do steps that are left over.
"""

from hal.scripted.can import ScriptedCan
from hal.scripted.cpu import ScriptedCpu, ScriptedLine
from hal.scripted.dual_port import ScriptedDualPort
from hal.scripted.flash import ScriptedFlash
from hal.scripted.i2c import ScriptedI2c
from hal.scripted.i2c_slave import ScriptedI2cSlave
from hal.scripted.packet_link import ScriptedPacketReceiver, ScriptedPacketSender
from hal.scripted.pins import ScriptedInput, ScriptedOutput
from hal.scripted.spi import ScriptedSpi
from hal.scripted.storage import ScriptedLog
from hal.scripted.timers import ScriptedCapture, ScriptedTimer
from hal.scripted.transcript import Transcript
from hal.scripted.uart import ScriptedUart
from hal.scripted.watchdog import ScriptedWatchdog

__all__ = [
    "ScriptedCan",
    "ScriptedCapture",
    "ScriptedCpu",
    "ScriptedDualPort",
    "ScriptedFlash",
    "ScriptedI2c",
    "ScriptedI2cSlave",
    "ScriptedInput",
    "ScriptedLine",
    "ScriptedLog",
    "ScriptedOutput",
    "ScriptedPacketReceiver",
    "ScriptedPacketSender",
    "ScriptedSpi",
    "ScriptedTimer",
    "ScriptedUart",
    "ScriptedWatchdog",
    "Transcript",
]
