"""Kinds of recordings and who reads them."""

from __future__ import annotations

from importlib import import_module

from host.importers.request import Reader, Recording, Task


def _late(module: str, name: str) -> Reader:
    """A reader whose libraries are loaded when it is used."""

    def read(task: Task) -> Recording:
        recording: Recording = getattr(import_module(f"host.importers.{module}"), name)(task)
        return recording

    return read


KINDS: dict[str, Reader] = {
    "ubx": _late("receiver_log", "read_ubx"),
    "nmea": _late("receiver_log", "read_nmea"),
    "can": _late("can_log", "read_can"),
    "kf-gins": _late("kf_gins", "read_kf_gins"),
    "csv": _late("csv_table", "read_csv"),
    "comma2k19": _late("comma2k19_arrays", "read_comma2k19"),
    "broad": _late("broad_arrays", "read_broad"),
}
OPTIONS = {
    "mapping": ("csv",),
    "dbc": ("can",),
    "week": ("kf-gins",),
    "date": ("nmea", "ubx"),
    "geoid_separation_m": ("nmea", "ubx"),
    "leap_seconds": ("ubx", "nmea", "can", "kf-gins", "csv", "comma2k19"),
    "accuracy": ("ubx", "nmea", "kf-gins", "csv", "comma2k19"),
}
"""Fields of a request that only some kinds heed."""
WHAT = {
    "ubx": "u-blox log: UBX, with NMEA in between",
    "nmea": "log of NMEA sentences",
    "can": "CAN log: candump, ASC, BLF, TRC, CSV, MF4 (python-can)",
    "kf-gins": "KF-GINS text files: increments, receiver, reference",
    "csv": "tables of numbers, by a mapping file",
    "comma2k19": "arrays of a comma2k19 drive",
    "broad": "arrays of a BROAD trial",
}
