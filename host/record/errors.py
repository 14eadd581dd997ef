"""The one error that a person's own mistake becomes."""

from __future__ import annotations


class UserError(Exception):
    """A mistake in what the user asked for: the command line shows the message alone and exits with 2.

    The message says in one go what is wrong, where, with which value, and how a valid one looks.
    """
