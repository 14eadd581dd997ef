"""Reading a trajectory by the ending of its file."""

from __future__ import annotations

from pathlib import Path

from host.record.errors import UserError
from host.simulate.tracks.csv_track import read_csv
from host.simulate.tracks.nmea_track import read_nmea
from host.simulate.tracks.own_track import read_capture, read_npz
from host.simulate.tracks.track import Track, check_gaps
from host.simulate.tracks.xml_track import read_gpx, read_kml

READERS = {
    ".csv": read_csv,
    ".gpx": read_gpx,
    ".nmea": read_nmea,
    ".log": read_nmea,
    ".npz": read_npz,
    ".mcap": read_capture,
}
PLACES = {".csv": "line", ".nmea": "line", ".log": "line", ".npz": "sample", ".mcap": "row"}


def read_track(path: Path, longest_gap_s: float, speed_mps: float | None = None) -> Track:
    """The trajectory of a file. Raises UserError that names file, place, value and what would be right."""
    suffix = path.suffix.lower()
    if suffix not in (*READERS, ".kml"):
        known = ", ".join((*READERS, ".kml"))
        raise UserError(f"{path}: is no known kind of trajectory; there are {known}")
    if not path.is_file():
        raise UserError(f"{path}: no such file")
    try:
        track, numbers = read_kml(path, speed_mps) if suffix == ".kml" else READERS[suffix](path)
    except UnicodeDecodeError as error:
        raise UserError(f"{path}: is not text: {error.reason} at byte {error.start}") from None
    except OSError as error:
        raise UserError(f"{path}: cannot be read: {error.strerror}") from None
    word = PLACES.get(suffix, "point")
    check_gaps(track, longest_gap_s, str(path), lambda k: f"{word} {numbers[k]}")
    return track
