"""The error of a wrong scenario."""


class ScenarioError(ValueError):
    """A scenario is wrong. The message names file, key, offending value and a valid example."""
