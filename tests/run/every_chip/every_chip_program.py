"""Reads every chip as fast as its data come, and looks after it when it does not answer."""

from firmware.drivers.adis16407 import Adis16407, Adis16407Config
from firmware.drivers.adxl345 import Adxl345, Adxl345Config
from firmware.drivers.adxl345_ports import SpiPort
from firmware.drivers.dual_antenna import DualAntennaSetup
from firmware.drivers.gr87 import Gr87Setup
from firmware.drivers.hmc6343 import Hmc6343, Hmc6343Config
from firmware.drivers.receiver_stream import ReceiverStream
from firmware.drivers.sentence_setup import SentenceConfigurator
from firmware.drivers.serial_imu import SerialImuStream
from firmware.link.frames import FrameWriter
from hal.pins import Edge


def program(io, profile, installation):
    return EveryChip(io)


class EveryChip:
    def __init__(self, io):
        self.io = io
        self.counts = dict.fromkeys(("acc", "adis", "compass", "imu", "gr87", "dual"), 0)

    def main(self):
        io = self.io
        self.link = FrameWriter()
        self.acc = Adxl345(SpiPort(io.spi["acc"]), io.cpu, Adxl345Config())
        self.adis = Adis16407(io.spi["adis"], io.cpu, Adis16407Config())
        self.compass = Hmc6343(io.i2c["i2c1"], io.cpu, Hmc6343Config())
        self.imu = SerialImuStream()
        self.listen("imu", "serial_imu", self.imu)
        self.receivers = {}
        for name, setup in (("gr87", Gr87Setup()), ("dual", DualAntennaSetup())):
            stream = ReceiverStream(baud=io.uart[name].baud)
            self.receivers[name] = SentenceConfigurator(io.uart[name], stream, setup)
            self.listen(name, name, stream)
        self.acc.start()
        self.adis.start()
        self.compass.start()
        io.inputs["adis_ready"].interrupt_on(Edge.RISING, io.interrupts.attach("adis_ready", self.on_adis))
        for round_number in range(1 << 30):
            io.cpu.delay(200_000_000)
            self.look_after(round_number)

    def listen(self, port, line_name, stream):
        uart = self.io.uart[port]

        def on_bytes():
            while stream.take(uart.received(), self.io.clock.now_ns()):
                self.counts[port] += 1

        uart.start_receive(stream.ring, self.io.interrupts.attach(line_name, on_bytes))

    def on_adis(self):
        self.adis.read()
        self.counts["adis"] += 1

    def look_after(self, round_number):
        for setup in self.receivers.values():
            setup.step(self.io.clock.now_ns())
        self.compass.read()
        self.counts["compass"] += 1
        self.acc.read()
        self.counts["acc"] += 1
        for chip in (self.acc, self.adis):
            chip.check()
        if round_number % 10 == 9:
            self.adis.identify()
            self.acc.identify()
            self.compass.identify()
            told = " ".join(f"{name}={count}" for name, count in self.counts.items())
            self.io.uart["host"].write(self.link.text(told))

    def spoil(self):
        pass

    def memory(self):
        return bytes(8)
