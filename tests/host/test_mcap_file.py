"""The MCAP file against the writer of the package `mcap`: the same calls give the same bytes."""

import io
import random

import pytest
from mcap.reader import make_reader
from mcap.writer import CompressionType, Writer

from host.capture.mcap_file import McapFile


class PackageFile:
    """The package's writer under the same calls."""

    def __init__(self, stream, profile, library):
        self._writer = Writer(stream, chunk_size=1 << 62, compression=CompressionType.LZ4)
        self._writer.start(profile=profile, library=library)
        self.register_schema = self._writer.register_schema
        self.register_channel = self._writer.register_channel
        self.add_metadata = self._writer.add_metadata
        self.flush = self._writer.flush
        self.finish = self._writer.finish

    def add_attachment(self, name, media_type, data):
        self._writer.add_attachment(0, 0, name, media_type, data)

    def add_message(self, channel, time_ns, data):
        self._writer.add_message(channel, time_ns, bytes(data), time_ns)


def written(kind, seed):
    rng = random.Random(seed)
    stream = io.BytesIO()
    file = kind(stream, "navtwin", "navtwin")
    file.add_attachment("manifest.json", "application/json", rng.randbytes(200))
    file.add_metadata("capture", {"format": "some", "more": ""})
    schemas = [file.register_schema(f"navtwin.S{k}", "json", b"{}" * k) for k in range(3)]
    channels = [file.register_channel(f"/topic/{k}", "json", schemas[k % 3]) for k in range(5)]
    for chunk in range(rng.randrange(20)):
        for _ in range(rng.randrange(12)):
            data = bytearray(rng.randbytes(rng.choice((0, 1, 40, 3000))))
            file.add_message(rng.choice(channels), rng.randrange(1 << 62), data)
        if chunk == 5:
            channels.append(file.register_channel("/late", "json", schemas[0]))
            file.add_metadata("between", {"chunk": "5"})
        file.flush()
    file.add_metadata("end", {"state_hash": "00"})
    file.finish()
    return stream.getvalue()


@pytest.mark.parametrize("seed", range(12))
def test_the_bytes_are_those_of_the_package(seed):
    assert written(McapFile, seed) == written(PackageFile, seed)


def test_messages_are_found_by_the_packages_reader():
    stream = io.BytesIO()
    file = McapFile(stream, "navtwin", "navtwin")
    channel = file.register_channel("/a", "json", file.register_schema("A", "json", b"{}"))
    for t_ns in (5, 3, 9):
        file.add_message(channel, t_ns, b"%d" % t_ns)
        file.flush()
    file.finish()
    found = [(m.log_time, m.data) for _s, _c, m in make_reader(io.BytesIO(stream.getvalue())).iter_messages()]
    assert found == [(3, b"3"), (5, b"5"), (9, b"9")]
