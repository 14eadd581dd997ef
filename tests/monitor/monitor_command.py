"""`navtwin monitor` in the tests' own process."""

import json
from typing import Any

from typer.testing import CliRunner, Result

from host.cli.main import app


def monitor(*arguments: str) -> Result:
    """As a user calls it."""
    return CliRunner().invoke(app, ["monitor", *arguments])


def last_line(*arguments: str) -> dict[str, Any]:
    """The last picture's figures."""
    result = monitor(*arguments, "--json")
    assert result.exit_code == 0, result.output
    last: dict[str, Any] = json.loads(result.stdout.splitlines()[-1])
    return last
