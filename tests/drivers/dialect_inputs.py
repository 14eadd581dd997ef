"""Inputs of the driver kernels for the dialect gate: real sentences and frames, whole, cut and spoilt."""

import numpy as np

from firmware.drivers.receiver_stream import ReceiverStream

TEXT = (
    b"$GNGGA,092725.00,5030.12345,N,00415.54321,W,1,09,0.95,87.4,M,48.1,M,,*6E\r\n"
    b"$GNRMC,092725.00,A,5030.12345,N,00415.54321,W,0.045,271.30,150324,,,A*68\r\n"
    b"$GPGSV,1,1,02,01,53,280,36,03,29,301,*73\r\n"
    b"$GNGSA,A,1,,,,,,,,,,,,,99.99,99.99,99.99*2E\r\n"
    b"$PUBX,00,092725.00,5030.12345,N,00415.54321,W,135.5,G3,2.1,3.4,1.25,271.3,-0.1,,0.9,1.2,0.8,9,0,0*66\r\n"
    b"\xb5\x62\x05\x01\x02\x00\x06\x08\x16\x3f$GNRMC,,V,,,,,,,,,,N*4D\r\n"
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


INPUTS = {"firmware.drivers.receiver_demux.demultiplex": stream}
