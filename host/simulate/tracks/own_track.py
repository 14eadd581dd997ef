"""Trajectories that navtwin wrote: NPZ of `navtwin simulate`, and captures (/truth, else /solution)."""

from __future__ import annotations

import json
import math
import struct
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
from mcap.exceptions import McapError
from mcap.reader import make_reader

from host.record.errors import UserError
from host.record.run_data import NAVIGATING
from host.simulate.tracks.track import Track, checked

TOPICS = ("/truth", "/solution")
_COLUMNS = (
    *("t_s", "latitude_deg", "longitude_deg", "height_m", "v_north_mps", "v_east_mps", "v_down_mps"),
    *("yaw_deg", "pitch_deg", "roll_deg"),
)


def read_npz(path: Path) -> tuple[Track, list[int]]:
    """The truth beside the samples. Raises UserError."""
    try:
        with np.load(path) as archive:
            imu: Any = archive["imu"]
            times_ns = np.asarray(imu["t_ns"], dtype=np.int64).reshape(-1)
            names = ("latitude", "longitude", "height", "yaw", "pitch", "roll")
            columns = {name: np.asarray(imu[name], dtype=np.float64).reshape(-1) for name in names}
            velocity = np.asarray(imu["velocity"], dtype=np.float64).reshape(len(imu), 3)
    except (OSError, EOFError, TypeError, ValueError, KeyError, IndexError, zipfile.BadZipFile) as error:
        raise UserError(f"{path}: is not what navtwin simulate writes as NPZ: {error}") from None
    t = (times_ns - times_ns[:1]) / 1e9
    attitude = np.column_stack((columns["yaw"], columns["pitch"], columns["roll"]))
    place = (columns["latitude"], columns["longitude"], columns["height"])
    track = Track(t, *place, velocity, attitude)
    return checked(track, str(path), lambda k: f"sample {k}"), list(range(len(track)))


def read_capture(path: Path) -> tuple[Track, list[int]]:
    """The truth of a simulated drive, else the solutions of a board that navigates. Raises UserError."""
    rows: dict[str, list[list[float]]] = {topic: [] for topic in TOPICS}
    try:
        with path.open("rb") as file:
            for _schema, channel, message in make_reader(file).iter_messages(topics=TOPICS):
                value = json.loads(message.data)
                if channel.topic == "/truth" or (value.get("mode") or 0) >= NAVIGATING:
                    row = [math.nan if value[name] is None else value[name] for name in _COLUMNS]
                    rows[channel.topic].append(row)
    except (McapError, struct.error, ValueError, KeyError, OSError) as error:
        raise UserError(f"{path}: is not a whole capture ({error or type(error).__name__})") from None
    topic = next((topic for topic in TOPICS if rows[topic]), None)
    if topic is None:
        raise UserError(f"{path}: holds neither /truth nor solutions of a board that navigates")
    table = np.array(rows[topic])
    angles = np.radians(table[:, [1, 2, 7, 8, 9]])
    motion = (table[:, 4:7], angles[:, 2:])
    noisy = topic != "/truth"
    track = Track(table[:, 0] - table[0, 0], angles[:, 0], angles[:, 1], table[:, 3], *motion, noisy=noisy)
    return checked(track, str(path), lambda k: f"row {k + 1}"), list(range(1, len(track) + 1))
