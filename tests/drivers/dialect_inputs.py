"""Inputs of the driver kernels for the dialect gate: real sentences and frames, whole, cut and spoilt."""

import numpy as np

from firmware.drivers.receiver_stream import ReceiverStream
from firmware.drivers.serial_imu import SerialImuStream
from firmware.drivers.serial_imu_frames import CUT

TEXT = (
    b"$GNGGA,092725.00,5030.12345,N,00415.54321,W,1,09,0.95,87.4,M,48.1,M,,*6E\r\n"
    b"$GNRMC,092725.00,A,5030.12345,N,00415.54321,W,0.045,271.30,150324,,,A*68\r\n"
    b"$GPGSV,1,1,02,01,53,280,36,03,29,301,*73\r\n"
    b"$GNGSA,A,1,,,,,,,,,,,,,99.99,99.99,99.99*2E\r\n"
    b"$PUBX,00,092725.00,5030.12345,N,00415.54321,W,135.5,G3,2.1,3.4,1.25,271.3,-0.1,,0.9,1.2,0.8,9,0,0*66\r\n"
    b"\xb5\x62\x05\x01\x02\x00\x06\x08\x16\x3f$GNRMC,,V,,,,,,,,,,N*4D\r\n"
)


FRAMES = bytes.fromhex(
    "aa55000020a10700340bdaff0000000017a4030000000000632eb5ff0400646f"
    "aa55010020a107008ca9d9ff00000000a9ac030000000000632eb5ff04007241"
    "aa55020020a10700e447d9ff0000000034b5030000000000632eb5ff0400105a"
)


def stream(rng: np.random.Generator) -> tuple[object, ...]:
    """A fresh stream whose ring holds the text, in some of the trials with bytes spoilt."""
    receiver = ReceiverStream(ring_length=1024)
    ring = np.frombuffer(receiver.ring, np.uint8)
    ring[: len(TEXT)] = np.frombuffer(TEXT, np.uint8)
    for _ in range(rng.integers(0, 8)):
        ring[rng.integers(0, len(TEXT))] = rng.integers(0, 256)
    start = int(rng.integers(0, 100))
    return receiver.state, ring, start, int(rng.integers(start, len(TEXT))), 10**9, receiver.epoch.copy()


def imu_stream(rng: np.random.Generator) -> tuple[object, ...]:
    """A stream of the serial unit with frames in its ring, in some of the trials with bytes spoilt."""
    imu = SerialImuStream(ring_length=256)
    ring = np.frombuffer(imu.ring, np.uint8)
    ring[: len(FRAMES)] = np.frombuffer(FRAMES, np.uint8)
    for _ in range(rng.integers(0, 4)):
        ring[rng.integers(0, len(FRAMES))] = rng.integers(0, 256)
    imu.state[CUT] = rng.integers(0, 2)
    start = int(rng.integers(0, 60))
    return imu.state, ring, start, int(rng.integers(start, len(FRAMES))), 10**9, imu.sample.copy()


INPUTS = {
    "firmware.drivers.receiver_demux.demultiplex": stream,
    "firmware.drivers.serial_imu_frames.find_frame": imu_stream,
}
