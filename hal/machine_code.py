"""What a class may tell the translator of `hal.engine_build`; interpreted it means nothing.

    @mypyc_attr(allow_interpreted_subclasses=True)
    class Output: ...

Without it a class that was translated cannot be a base class of interpreted ones.
"""

from collections.abc import Callable
from typing import TYPE_CHECKING, TypeVar

if TYPE_CHECKING:
    from mypy_extensions import mypyc_attr as mypyc_attr
else:
    Class = TypeVar("Class", bound=type)

    def mypyc_attr(**_told: bool) -> Callable[[Class], Class]:
        """In place of the one in `mypy_extensions`, which only the translator needs."""
        return lambda told_class: told_class
