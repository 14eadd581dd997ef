"""The engine as machine code: taken for exactly its sources, built whole or not at all."""

import os
import shutil
import subprocess
import sys
import sysconfig
from pathlib import Path

import pytest

from hal import engine, engine_build
from hal.engine_modules import GROUPS

ROOT = Path(engine.__file__).parents[1]
GROUP = "emulation"
NOT_BUILT = "the engine is not built as it is now (python -m hal.engine_build): everything ran interpreted"


def _needs_the_engine() -> None:
    """Without a C compiler there is none, and the test is skipped; with one it has to be there."""
    if all(engine.folder(group).exists() for group in GROUPS):
        return
    compiler = (os.environ.get("CC") or sysconfig.get_config_var("CC") or "cc").split()[0]
    header = Path(sysconfig.get_path("include")) / "Python.h"
    if shutil.which(compiler) is None or not header.exists():
        pytest.skip(NOT_BUILT)
    pytest.fail(NOT_BUILT)


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
    _needs_the_engine()
    assert _origin_of_the_processor().startswith(str(engine.folder(GROUP)))


@pytest.mark.parametrize("choice", ["interpreted", "firmware"])
def test_sources_are_taken_where_that_is_chosen(choice: str) -> None:
    origin = _origin_of_the_processor(**{engine.CHOICE: choice})
    assert origin == str(ROOT / "hal" / "emulated" / "cpu.py")


def test_a_changed_source_does_not_hide_behind_old_machine_code_and_leaves_the_other_groups_theirs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    originals = {group: engine.sources(group) for group in GROUPS}
    monkeypatch.setattr(engine, "_ROOT", tmp_path)
    for group, files in originals.items():
        for original, copy in zip(files, engine.sources(group), strict=True):
            copy.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(original, copy)
    before = {group: engine.folder(group) for group in GROUPS}
    assert before == {group: engine.folder(group) for group in GROUPS}
    for changed in GROUPS:
        for path in engine.sources(changed):
            text = path.read_text()
            path.write_text(text + "\n")
            differing = [group for group in GROUPS if engine.folder(group) != before[group]]
            assert differing == [changed], path
            path.write_text(text)


def test_no_module_is_in_two_groups() -> None:
    names = [name for modules in GROUPS.values() for name in modules]
    assert len(names) == len(set(names))


def test_another_interpreter_takes_no_foreign_machine_code(monkeypatch: pytest.MonkeyPatch) -> None:
    before = engine.folder(GROUP)
    monkeypatch.setattr(sys, "version", "3.99")
    assert engine.folder(GROUP) != before


def test_without_a_compiler_nothing_is_left_and_the_message_names_the_package(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "prefix", str(tmp_path))
    monkeypatch.setitem(GROUPS, GROUP, ("hal.emulated.virtual_time",))
    for variable in ("CC", "LDSHARED"):
        monkeypatch.setenv(variable, "/no/such/compiler")
    with pytest.raises(engine_build.NotPossibleError, match="apt install gcc python3-dev"):
        engine_build.build(GROUP)
    assert not list((tmp_path / "lib" / "navtwin-engine").iterdir())


def test_an_environment_that_cannot_be_written_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "lib").write_text("a file")
    monkeypatch.setattr(sys, "prefix", str(tmp_path))
    with pytest.raises(engine_build.NotPossibleError, match="navtwin-engine cannot be written"):
        engine_build.build(GROUP)


def _fill(_group: str, folder: Path) -> None:
    """In place of `engine_build._compile`, which takes half a minute."""
    (folder / f"{engine.library(GROUP)}.so").write_text("machine code")


def _pretend_to_compile(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(sys, "prefix", str(tmp_path))
    monkeypatch.setattr(engine_build, "_compile", _fill)
    return tmp_path / "lib" / "navtwin-engine"


def test_two_builds_at_once_leave_one_engine(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    builds = _pretend_to_compile(tmp_path, monkeypatch)

    def overtaken(group: str, folder: Path) -> None:
        monkeypatch.setattr(engine_build, "_compile", _fill)
        engine_build.build(GROUP)
        _fill(group, folder)

    monkeypatch.setattr(engine_build, "_compile", overtaken)
    assert engine_build.build(GROUP) == engine.folder(GROUP)
    assert list(builds.iterdir()) == [engine.folder(GROUP)]


def test_what_an_interrupted_build_left_goes_with_a_later_one_but_never_a_running_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    builds = _pretend_to_compile(tmp_path, monkeypatch)
    old, running = builds / "being-built-old", builds / "being-built-now"
    complete = [builds / f"{GROUP}-{age}" for age in range(6)]
    other_group, of_no_group = builds / "firmware-0", builds / "7d90e8e0d2bf4d53"
    for folder in (old, running, other_group, of_no_group, *complete):
        folder.mkdir(parents=True)
    now = running.stat().st_mtime
    os.utime(old, (now - 7200, now - 7200))
    for age, folder in enumerate(complete):
        os.utime(folder, (now - 60 * age - 60, now - 60 * age - 60))
    engine_build.build(GROUP)
    kept = complete[: engine_build.BUILDS_KEPT]
    assert set(builds.iterdir()) == {engine.folder(GROUP), running, other_group, *kept}


def test_the_engine_can_be_read_by_who_may_read_the_environment(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    _pretend_to_compile(tmp_path, monkeypatch)
    assert engine_build.build(GROUP).stat().st_mode & 0o777 == 0o755


def test_sources_that_change_during_the_build_are_not_taken_for_what_was_built(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    builds = _pretend_to_compile(tmp_path, monkeypatch)
    monkeypatch.setattr(engine_build, "_compile", lambda *_: monkeypatch.setattr(sys, "version", "3.99"))
    with pytest.raises(engine_build.NotPossibleError, match="changed meanwhile"):
        engine_build.build(GROUP)
    assert not list(builds.iterdir())


def test_a_refusal_of_the_translator_is_one_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    source = tmp_path / "hal" / "emulated" / "virtual_time.py"
    source.parent.mkdir(parents=True)
    source.write_text("now = = 'noon'\n")
    monkeypatch.setattr(sys, "prefix", str(tmp_path))
    monkeypatch.setattr(engine, "_ROOT", tmp_path)
    monkeypatch.setattr(engine_build, "PACKAGE_ROOT", tmp_path)
    monkeypatch.setitem(GROUPS, GROUP, ("hal.emulated.virtual_time",))
    with pytest.raises(engine_build.NotPossibleError, match="mypyc does not translate"):
        engine_build.build(GROUP)


def test_a_package_without_sources_is_simply_interpreted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(engine, "_ROOT", tmp_path)
    monkeypatch.setattr(sys, "meta_path", [])
    monkeypatch.delenv(engine.CHOICE, raising=False)
    engine.use()
    engine.use()
    (finder,) = sys.meta_path
    assert finder.find_spec("hal.emulated.cpu", None) is None


def _hashes_of_run_and_capture(out: Path, choice: str) -> str:
    program = (
        "import hashlib, sys\n"
        "from pathlib import Path\n"
        "from hal import engine\n"
        "from host.record.result import RunRequest\n"
        "from host.run.runner import run\n"
        "out = Path(sys.argv[1])\n"
        "ran = run(RunRequest('car_mems', 'static', overrides=('duration_s=3',), out_dir=out))\n"
        "capture = hashlib.sha256((out / 'run.mcap').read_bytes()).hexdigest()\n"
        "print(engine.description(), ran.state_hash, capture, sep='|')\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", program, str(out)],
        env={**os.environ, engine.CHOICE: choice, "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        timeout=120,
        check=True,
    )
    taken, hashes = done.stdout.strip().splitlines()[-1].split("|", 1)
    assert taken == (
        f"machine code ({choice.replace(',', ', ')})" if choice in CHOICES[1:] else "interpreted"
    )
    return hashes


CHOICES = ("interpreted", *GROUPS, ",".join(GROUPS))


def test_every_group_gives_the_same_bytes_beside_every_other(tmp_path: Path) -> None:
    _needs_the_engine()
    hashes = [_hashes_of_run_and_capture(tmp_path / choice, choice) for choice in CHOICES]
    assert set(hashes) == {hashes[0]}
