"""Scenario files: schema, loading, overrides and messages."""
