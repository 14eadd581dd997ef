"""The engine as machine code: taken for exactly its sources, built whole or not at all."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from hal import engine, engine_build

ROOT = Path(engine.__file__).parents[1]


def _origin_of_the_processor(**environment: str) -> str:
    program = "import hal.emulated.cpu as cpu; print(cpu.__file__)"
    variables = {key: value for key, value in os.environ.items() if key != engine.CHOICE}
    done = subprocess.run(
        [sys.executable, "-c", program],
        env={**variables, **environment, "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        timeout=60,
        check=True,
    )
    return done.stdout.strip()


def test_what_is_built_is_taken() -> None:
    if not engine.folder().exists():
        pytest.skip("the engine is not built here (python -m hal.engine_build): everything ran interpreted")
    assert _origin_of_the_processor().startswith(str(engine.folder()))


def test_sources_are_taken_where_that_is_chosen() -> None:
    origin = _origin_of_the_processor(**{engine.CHOICE: "interpreted"})
    assert origin == str(ROOT / "hal" / "emulated" / "cpu.py")


def test_a_changed_source_does_not_hide_behind_old_machine_code(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    originals = engine.sources()
    monkeypatch.setattr(engine, "_ROOT", tmp_path)
    for original, copy in zip(originals, engine.sources(), strict=True):
        copy.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(original, copy)
    before = engine.folder()
    assert before == engine.folder()
    for path in engine.sources():
        text = path.read_text()
        path.write_text(text + "\n")
        assert engine.folder() != before, path
        path.write_text(text)


def test_another_interpreter_takes_no_foreign_machine_code(monkeypatch: pytest.MonkeyPatch) -> None:
    before = engine.folder()
    monkeypatch.setattr(sys, "version", "3.99")
    assert engine.folder() != before


def test_without_a_compiler_nothing_is_left_and_the_message_names_the_package(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "prefix", str(tmp_path))
    monkeypatch.setattr(engine, "MODULES", ("hal.emulated.virtual_time",))
    for variable in ("CC", "LDSHARED"):
        monkeypatch.setenv(variable, "/no/such/compiler")
    with pytest.raises(engine_build.NotPossibleError, match="apt install gcc python3-dev"):
        engine_build.build()
    assert not list((tmp_path / "lib" / "navtwin-engine").iterdir())


def test_an_environment_that_cannot_be_written_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "lib").write_text("a file")
    monkeypatch.setattr(sys, "prefix", str(tmp_path))
    with pytest.raises(engine_build.NotPossibleError, match="navtwin-engine cannot be written"):
        engine_build.build()


def _fill(folder: Path) -> None:
    """In place of `engine_build._compile`, which takes half a minute."""
    (folder / f"{engine.LIBRARY}.so").write_text("machine code")


def _pretend_to_compile(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(sys, "prefix", str(tmp_path))
    monkeypatch.setattr(engine_build, "_compile", _fill)
    return tmp_path / "lib" / "navtwin-engine"


def test_two_builds_at_once_leave_one_engine(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    builds = _pretend_to_compile(tmp_path, monkeypatch)

    def overtaken(folder: Path) -> None:
        monkeypatch.setattr(engine_build, "_compile", _fill)
        engine_build.build()
        _fill(folder)

    monkeypatch.setattr(engine_build, "_compile", overtaken)
    assert engine_build.build() == engine.folder()
    assert list(builds.iterdir()) == [engine.folder()]


def test_what_an_interrupted_build_left_goes_with_a_later_one_but_never_a_running_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    builds = _pretend_to_compile(tmp_path, monkeypatch)
    old, running = builds / "being-built-old", builds / "being-built-now"
    complete = [builds / f"build{age}" for age in range(6)]
    for folder in (old, running, *complete):
        folder.mkdir(parents=True)
    now = running.stat().st_mtime
    os.utime(old, (now - 7200, now - 7200))
    for age, folder in enumerate(complete):
        os.utime(folder, (now - 60 * age - 60, now - 60 * age - 60))
    engine_build.build()
    assert set(builds.iterdir()) == {engine.folder(), running, *complete[: engine_build.BUILDS_KEPT]}


def test_the_engine_can_be_read_by_who_may_read_the_environment(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    _pretend_to_compile(tmp_path, monkeypatch)
    assert engine_build.build().stat().st_mode & 0o777 == 0o755


def test_sources_that_change_during_the_build_are_not_taken_for_what_was_built(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    builds = _pretend_to_compile(tmp_path, monkeypatch)
    monkeypatch.setattr(engine_build, "_compile", lambda _folder: monkeypatch.setattr(sys, "version", "3.99"))
    with pytest.raises(engine_build.NotPossibleError, match="changed meanwhile"):
        engine_build.build()
    assert not list(builds.iterdir())


def test_a_refusal_of_the_translator_is_one_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    source = tmp_path / "hal" / "emulated" / "virtual_time.py"
    source.parent.mkdir(parents=True)
    source.write_text("now: int = 'noon'\n")
    monkeypatch.setattr(sys, "prefix", str(tmp_path))
    monkeypatch.setattr(engine, "_ROOT", tmp_path)
    monkeypatch.setattr(engine_build, "PACKAGE_ROOT", tmp_path)
    monkeypatch.setattr(engine, "MODULES", ("hal.emulated.virtual_time",))
    with pytest.raises(engine_build.NotPossibleError, match="mypyc does not translate"):
        engine_build.build()


def test_a_package_without_sources_is_simply_interpreted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(engine, "_ROOT", tmp_path)
    monkeypatch.setattr(sys, "meta_path", [])
    monkeypatch.delenv(engine.CHOICE, raising=False)
    engine.use()
    assert sys.meta_path == []


def _hash_and_capture(out: Path, **environment: str) -> tuple[str, bytes]:
    variables = {key: value for key, value in os.environ.items() if key != engine.CHOICE}
    command = [sys.executable, "-m", "host.cli.main", "run", "car_mems", "-s", "static", "-q"]
    subprocess.run(
        [*command, "--set", "duration_s=5", "--out", str(out), "--json", str(out.with_suffix(".json"))],
        env={**variables, **environment, "PYTHONPATH": str(ROOT)},
        cwd=out.parent,
        timeout=120,
        check=False,  # expectations of the scenario want a longer run
    )
    figures = json.loads(out.with_suffix(".json").read_text())
    return figures["state_hash"], (out / "run.mcap").read_bytes()


def test_machine_code_gives_the_same_bytes(tmp_path: Path) -> None:
    if not engine.folder().exists():
        pytest.skip("the engine is not built here (python -m hal.engine_build): everything ran interpreted")
    compiled = _hash_and_capture(tmp_path / "compiled")
    assert compiled == _hash_and_capture(tmp_path / "interpreted", **{engine.CHOICE: "interpreted"})
