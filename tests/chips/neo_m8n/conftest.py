"""Fixtures of the receiver's tests."""

import pytest
from neo_m8n_rig import Rig, quiet_rig


@pytest.fixture
def rig() -> Rig:
    """A receiver that sends nothing unless asked."""
    return quiet_rig()
