"""Many messages at once are the same file as one after the other, and the mcap package reads both."""

from io import BytesIO

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from mcap.reader import make_reader

from host.capture.mcap_file import McapFile

MESSAGES = st.lists(st.tuples(st.integers(0, 1 << 62), st.binary(max_size=40)), min_size=1, max_size=30)


def written(batches, at_once):
    stream = BytesIO()
    file = McapFile(stream, "test", "test")
    channel = file.register_channel("/a", "json", file.register_schema("a", "", b""))
    other = file.register_channel("/b", "json", 0)
    for batch in batches:
        file.add_message(other, 7, b"between")
        if at_once:
            texts = np.frombuffer(b"".join(data for _t, data in batch) + b"unused", np.uint8)
            ends = np.cumsum([len(data) for _t, data in batch])
            file.add_messages(channel, np.array([t for t, _data in batch]), texts, ends)
        else:
            for t_ns, data in batch:
                file.add_message(channel, t_ns, data)
        if file.waiting_bytes > 500:
            file.flush()
    file.finish()
    return stream.getvalue()


@given(st.lists(MESSAGES, max_size=4))
def test_at_once_and_one_by_one_are_the_same_bytes(batches):
    assert written(batches, at_once=True) == written(batches, at_once=False)


@given(st.lists(MESSAGES, min_size=1, max_size=4))
def test_the_mcap_package_reads_every_message(batches):
    reader = make_reader(BytesIO(written(batches, at_once=True)), validate_crcs=True)
    read = [(message.log_time, message.data) for _s, _c, message in reader.iter_messages(["/a"])]
    assert sorted(read) == sorted(message for batch in batches for message in batch)


def test_no_messages_at_once_leave_no_trace():
    stream = BytesIO()
    file = McapFile(stream, "test", "test")
    file.add_messages(1, np.zeros(0, np.int64), np.zeros(0, np.uint8), np.zeros(0, np.int64))
    assert file.waiting_bytes == 0
