"""Base of all segments of a motion: they follow one another, so that none can overlap another one."""

from __future__ import annotations

from typing import Any

from pydantic import model_validator

from host.sim.schema import Table

INSTANTS = ("start_s", "begin_s", "at_s", "end_s", "from_s", "to_s", "until_s")


class SegmentTable(Table):
    """What all kinds of segments have in common."""

    @model_validator(mode="before")
    @classmethod
    def _follows_the_one_before(cls, data: Any) -> Any:
        for key in INSTANTS if isinstance(data, dict) else ():
            if key in data:
                raise ValueError(
                    f"{key} = {data[key]!r}: a segment begins where the one before ends, so that none"
                    " overlap; leave it out"
                )
        return data
