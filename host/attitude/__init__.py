"""Attitude filters on recordings with a reference: ours, directly and through chips, beside others."""
