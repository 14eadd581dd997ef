"""The journal keeps what is finished: torn lines, full disks, foreign files, two writers."""

from __future__ import annotations

import errno
import json
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from host.campaign.folder import open_folder
from host.campaign.journal import JOURNAL, Outcome
from host.record.errors import UserError

MANIFEST = {"format": "navtwin-campaign-1", "board": "b", "sources": "abc"}


def outcome(number: int) -> Outcome:
    return Outcome(f"seed={number}", number, {"run": number, "status": "finished"}, times={"total_s": 1.0})


def test_what_was_added_is_there_again(tmp_path: Path) -> None:
    with open_folder(tmp_path / "c", MANIFEST) as journal:
        journal.add(outcome(1))
        journal.add(outcome(0))
    with open_folder(tmp_path / "c", MANIFEST) as journal:
        assert list(journal.outcomes) == ["seed=1", "seed=0"]
        assert journal.outcomes["seed=0"].row == {"run": 0, "status": "finished"}
    assert "total_s" not in (tmp_path / "c" / JOURNAL).read_text()


@pytest.mark.parametrize("lost", [1, 5, 40])
def test_torn_line_is_cut_off_and_the_next_one_is_whole(tmp_path: Path, lost: int) -> None:
    with open_folder(tmp_path / "c", MANIFEST) as journal:
        journal.add(outcome(1))
        journal.add(outcome(2))
    path = tmp_path / "c" / JOURNAL
    os.truncate(path, path.stat().st_size - lost)
    with open_folder(tmp_path / "c", MANIFEST) as journal:
        assert list(journal.outcomes) == ["seed=1"]
        journal.add(outcome(3))
    assert [json.loads(line).get("key") for line in path.read_text().splitlines()] == [
        None,
        "seed=1",
        "seed=3",
    ]


def test_full_disk_keeps_finished_runs_and_leaves_no_half_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    really = os.pwrite

    def half_then_full(file: int, data: bytes, at: int) -> int:
        monkeypatch.setattr(
            os, "pwrite", lambda *_: (_ for _ in ()).throw(OSError(errno.ENOSPC, "No space left"))
        )
        return really(file, data[: len(data) // 2], at)

    with open_folder(tmp_path / "c", MANIFEST) as journal:
        journal.add(outcome(1))
        monkeypatch.setattr(os, "pwrite", half_then_full)
        with pytest.raises(OSError, match="No space left") as told:
            journal.add(outcome(2))
    assert told.value.filename == str(tmp_path / "c" / JOURNAL)
    monkeypatch.undo()
    assert (tmp_path / "c" / JOURNAL).read_bytes().endswith(b"}\n")
    with open_folder(tmp_path / "c", MANIFEST) as journal:
        assert list(journal.outcomes) == ["seed=1"]


def test_another_campaign_names_what_differs(tmp_path: Path) -> None:
    with open_folder(tmp_path / "c", MANIFEST) as journal:
        journal.add(outcome(1))
    with pytest.raises(UserError, match="differs in seeds, sources"):
        open_folder(tmp_path / "c", {**MANIFEST, "sources": "other", "seeds": "1-2"})


def test_folder_without_a_run_is_free_for_another_campaign(tmp_path: Path) -> None:
    open_folder(tmp_path / "c", MANIFEST).close()
    with open_folder(tmp_path / "c", {**MANIFEST, "sources": "other"}) as journal:
        journal.add(outcome(1))
    with open_folder(tmp_path / "c", {**MANIFEST, "sources": "other"}) as journal:
        assert list(journal.outcomes) == ["seed=1"]


@pytest.mark.parametrize("name", ["campaign.json", JOURNAL])
def test_result_of_another_version_is_refused(tmp_path: Path, name: str) -> None:
    with open_folder(tmp_path / "c", MANIFEST) as journal:
        journal.add(outcome(1))
    path = tmp_path / "c" / name
    path.write_text(path.read_text().replace("navtwin-campaign-1", "navtwin-campaign-0"))
    with pytest.raises(UserError, match="'navtwin-campaign-0', this navtwin writes 'navtwin-campaign-1'"):
        open_folder(tmp_path / "c", MANIFEST)


def test_folder_of_somebody_else_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "letter.txt").write_text("dear …")
    with pytest.raises(UserError, match="not the folder of a campaign"):
        open_folder(tmp_path, MANIFEST)
    assert [path.name for path in tmp_path.iterdir()] == ["letter.txt"]


def test_spoilt_line_in_the_middle_is_told(tmp_path: Path) -> None:
    with open_folder(tmp_path / "c", MANIFEST) as journal:
        journal.add(outcome(1))
    path = tmp_path / "c" / JOURNAL
    path.write_text(path.read_text() + "no json\n")
    with pytest.raises(UserError, match="line 3"):
        open_folder(tmp_path / "c", MANIFEST)


@pytest.fixture
def written_by_another(tmp_path: Path) -> Iterator[tuple[Path, subprocess.Popen[str]]]:
    """A folder, and a process that has put one run there and holds it open."""
    folder = tmp_path / "c"
    program = f"""if True:
        import itertools, sys
        from pathlib import Path
        from host.campaign.folder import open_folder
        from host.campaign.journal import Outcome
        journal = open_folder(Path({str(folder)!r}), {MANIFEST!r})
        for line in itertools.chain(["begun"], sys.stdin):
            journal.add(Outcome(line.strip(), 0, {{"run": 0}}))
            print("added", flush=True)
    """
    other = subprocess.Popen(
        [sys.executable, "-c", program], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    try:
        assert other.stdout is not None
        assert other.stdout.readline() == "added\n"
        yield folder, other
    finally:
        other.kill()
        other.communicate()


@pytest.mark.parametrize("fresh", [False, True])
def test_folder_that_is_being_written_is_left_alone(
    written_by_another: tuple[Path, subprocess.Popen[str]], fresh: bool
) -> None:
    folder, other = written_by_another
    before = (folder / JOURNAL).read_bytes()
    for _ in range(2):  # a refused attempt must not open the way for the next one
        with pytest.raises(UserError, match="another campaign is writing"):
            open_folder(folder, MANIFEST, fresh)
    assert other.stdin is not None
    assert other.stdout is not None
    other.stdin.write("later\n")
    other.stdin.flush()
    assert other.stdout.readline() == "added\n"
    now = (folder / JOURNAL).read_bytes()
    assert now.startswith(before)
    assert b"later" in now


def test_folder_of_a_killed_process_is_free(
    written_by_another: tuple[Path, subprocess.Popen[str]],
) -> None:
    folder, other = written_by_another
    other.kill()
    other.wait()
    with open_folder(folder, MANIFEST) as journal:
        assert list(journal.outcomes) == ["begun"]
    with open_folder(folder, MANIFEST, fresh=True) as journal:
        assert not journal.outcomes
