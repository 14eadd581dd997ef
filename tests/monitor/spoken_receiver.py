"""What a plain receiver prints, its checksums from another library."""

import pynmeagps

SEEN = ("05", "62", "110", "47", "13", "35", "290", "41", "15", "20", "020", "33", "20", "05", "340", "")


def sentences(seconds: int) -> bytes:
    """A receiver that drives north from 48.1° N at 5 m/s, printed by another library."""
    out = bytearray()
    for t in range(seconds):
        time_of_day = f"0900{t:02d}.00"
        lat = f"4806.{t * 27:04d}"
        common = (lat, "N", "01130.0000", "E")
        out += nmea("RMC", time_of_day, "A", *common, "9.719", "0.00", "150324", "", "", "A")
        out += nmea("GGA", time_of_day, *common, "1", "05", "0.90", "520.0", "M", "47.0", "M", "", "")
        out += nmea("GSA", "A", "3", "05", "13", "15", "20", "29", *[""] * 7, "1.50", "0.90", "1.20")
        out += nmea("GSV", "1", "1", "04", *SEEN)
    return bytes(out)


def nmea(kind: str, *fields: str) -> bytes:
    """A sentence with its checksum from pynmeagps."""
    body = ",".join((f"GP{kind}", *fields))
    return f"${body}*{pynmeagps.calc_checksum(body)}\r\n".encode()
