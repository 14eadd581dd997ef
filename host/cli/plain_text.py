"""Signs that a terminal or file cannot show, as it can: `<=` for ≤."""

from __future__ import annotations

import codecs

PLAINLY = "plainly"
"""The name for `errors=` of a text stream."""
SIGNS = {
    "≤": "<=",
    "≥": ">=",
    "×": "x",
    "–": "-",
    "−": "-",
    "…": "...",
    "°": " deg",
    "µ": "u",
    "²": "2",
    "·": ".",
}


def _plainly(error: UnicodeError) -> tuple[str, int]:
    if not isinstance(error, UnicodeEncodeError):
        raise error
    signs = error.object[error.start : error.end]
    return "".join(SIGNS.get(sign, "?") for sign in signs), error.end


codecs.register_error(PLAINLY, _plainly)
