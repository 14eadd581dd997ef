"""Scores: how far a solution was from the truth, streamed over a run of any length in bounded memory."""
