"""Imported captures that another program has changed: one message, exit code 2."""

from dataclasses import replace

import pytest
from circle_drive import write_kf_gins
from imports import imported, navtwin

from host.capture.copying import CaptureCopy
from host.capture.reader import CaptureReader


@pytest.fixture
def capture(tmp_path):
    return imported(tmp_path, "kf-gins", *write_kf_gins(tmp_path))[1]


def rewritten(source, changes, change=lambda _topic, data: data):
    """A copy with `changes` in its manifest and other texts of messages."""
    target = source.with_name("rewritten.mcap")
    reader = CaptureReader(source)
    copy = None
    with target.open("wb") as file:
        for message in reader.messages():
            copy = copy or CaptureCopy(file, reader, changes)
            copy.take(replace(message, data=change(message.topic, message.data)))
        copy.finish()
    return target


def driven(capture):
    """What is told when a board shall be driven by it."""
    outcome = navtwin("replay", capture, "--board", "car_mems", "--mode", "physical", "-q")
    assert outcome.exit_code == 2, outcome.output
    return outcome.stderr


@pytest.mark.parametrize(
    "clock", [[1], {"base": "gps"}, {"base": "gps", "leap_seconds": 18, "origin_ns": "x"}]
)
def test_an_impossible_clock_is_told(clock, capture):
    assert "'clock' is" in driven(rewritten(capture, {"clock": clock}))


def test_a_column_that_is_missing_is_told(capture):
    def change(topic, data):
        return data.replace(b'"height_m"', b'"heigth_m"') if topic == "/gnss" else data

    told = driven(rewritten(capture, {}, change))
    assert "a row of /gnss is damaged: the column 'height_m' is missing" in told
