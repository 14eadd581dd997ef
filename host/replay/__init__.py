"""Replay: a board's firmware runs again on what a capture holds, exactly or on other settings."""
