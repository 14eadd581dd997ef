"""A worker of a Dask cluster that is killed in the middle of a campaign."""

from __future__ import annotations

import os
import signal
import time
from pathlib import Path
from threading import Thread

import pytest
from campaign_rig import campaign, rows
from typer.testing import Result

from host.campaign.journal import JOURNAL

LONGER = ("--set", "duration_s=150")
SEEDS = "1-6"


def _lines(journal: Path) -> int:
    return journal.read_bytes().count(b"\n") if journal.exists() else 0


@pytest.mark.soak
def test_a_cluster_worker_killed_in_the_middle_costs_no_run(tmp_path: Path) -> None:
    """One of two is killed when some runs are on disk: those stay, what it had under way is done again."""
    distributed = pytest.importorskip("distributed")
    results: list[Result] = []
    journal = tmp_path / "dask" / JOURNAL
    options = {"threads_per_worker": 1, "dashboard_address": ":0"}
    with (
        distributed.LocalCluster(n_workers=2, **options) as local,
        distributed.Client(local, set_as_default=False) as client,
    ):
        processes = client.run(os.getpid)
        address = local.scheduler_address
        running = Thread(
            target=lambda: results.append(
                campaign(tmp_path / "dask", *LONGER, "--scheduler", address, seeds=SEEDS)
            )
        )
        running.start()
        deadline = time.monotonic() + 60
        while _lines(journal) < 2 and running.is_alive():
            assert time.monotonic() < deadline
            time.sleep(0.005)
        before = journal.read_bytes()
        victim = sorted(processes.values())[0]
        os.kill(victim, signal.SIGKILL)
        running.join(timeout=120)
        assert not running.is_alive()
        after = client.run(os.getpid)
    assert victim not in after.values()
    assert before.count(b"\n") < 7, "it was killed too late to be in the middle"
    assert journal.read_bytes().startswith(before), "finished runs stay as they were"
    (result,) = results
    assert result.exit_code == 0, result.output
    assert [row["status"] for row in rows(tmp_path / "dask")] == ["finished"] * 6
    campaign(tmp_path / "whole", *LONGER, "-j", 2, seeds=SEEDS)
    for name in ("runs.parquet", "summary.json", "report.html"):
        assert (tmp_path / "dask" / name).read_bytes() == (tmp_path / "whole" / name).read_bytes(), name
