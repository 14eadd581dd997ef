"""The folder of compiled kernels: named after the sources, safe to share, never in the way."""

import os
import re
import shutil
import stat
import subprocess
import sys
from pathlib import Path

import pytest

from firmware.numerics import cache_folder

REPOSITORY = Path(__file__).resolve().parents[2]
HASH = "import sys; from firmware.numerics.cache_folder import *; print(kernel_sources_hash('one'))"
CALL = "from firmware.sample.outer import outer; print(outer(5.0), outer.stats.cache_hits)"


def run(program, root=REPOSITORY, **variables):
    # Python's own byte code does not see a change of equal length within a second; it is not what is tested.
    given = {"PYTHONPATH": str(root), "NUMBA_DISABLE_JIT": "0", "PYTHONDONTWRITEBYTECODE": "1"}
    environment = os.environ | given | variables
    return subprocess.Popen(
        [sys.executable, "-c", program], env=environment, stdout=subprocess.PIPE, text=True, cwd=root
    )


def output(process):
    text, _ = process.communicate(timeout=120)
    assert process.returncode == 0
    return text.strip()


@pytest.fixture
def copy(tmp_path):
    """A firmware of its own: one kernel, a constant it imports, a file that nothing imports."""
    root = tmp_path / "product"
    ignored = shutil.ignore_patterns("__pycache__")
    shutil.copytree(REPOSITORY / "firmware" / "numerics", root / "firmware" / "numerics", ignore=ignored)
    (root / "firmware" / "__init__.py").touch()
    package = root / "firmware" / "sample"
    package.mkdir()
    (package / "__init__.py").touch()
    (package / "constants.py").write_text("import numpy as np\nGAIN = np.float32(2.0)\n")
    (package / "plain.py").write_text("UNUSED = 1\n")
    (package / "inner.py").write_text(
        "from firmware.numerics.dialect import kernel\nfrom firmware.sample.constants import GAIN\n"
        "@kernel\ndef inner(x):\n    return x * GAIN\n"
    )
    (package / "outer.py").write_text(
        "from firmware.numerics.dialect import kernel\nfrom firmware.sample.inner import inner\n"
        '@kernel("float32(float32)")\ndef outer(x):\n    return inner(x)\n'
    )
    return root


def change(path, old, new):
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))


@pytest.mark.parametrize(
    ("file", "old", "new"), [("inner.py", "x * GAIN", "x + GAIN"), ("constants.py", "2.0", "3.0")]
)
def test_a_change_in_what_a_kernel_calls_or_reads_is_seen(copy, tmp_path, file, old, new):
    program = "from firmware.sample.outer import outer; print(outer(5.0))"
    cache = {"XDG_CACHE_HOME": str(tmp_path / "cache")}
    assert output(run(program, copy, **cache)) == "10.0"
    change(copy / "firmware" / "sample" / file, old, new)
    assert output(run(program, copy, **cache)) == {"inner.py": "7.0", "constants.py": "15.0"}[file]


def test_hash_depends_on_sources_of_kernels_and_on_versions(copy):
    before = output(run(HASH, copy))
    change(copy / "firmware" / "sample" / "plain.py", "1", "2")
    assert output(run(HASH, copy)) == before
    change(copy / "firmware" / "sample" / "constants.py", "2.0", "2.5")
    assert output(run(HASH, copy)) != before
    assert cache_folder.kernel_sources_hash("one") != cache_folder.kernel_sources_hash("two")


def test_processes_that_compile_at_once_do_not_disturb_each_other(copy, tmp_path):
    cache = {"XDG_CACHE_HOME": str(tmp_path / "cache")}
    processes = [run(CALL, copy, **cache) for _ in range(2)]
    assert {output(process).split()[0] for process in processes} == {"10.0"}
    assert re.fullmatch(r"10\.0 Counter\(\{.*: 1\}\)", output(run(CALL, copy, **cache)))


def test_kernel_outside_firmware_sees_a_change_in_the_file_beside_it(copy, tmp_path):
    """A test's own kernel that calls one of another test file."""
    (tmp_path / "beside.py").write_text(
        "from firmware.numerics.dialect import kernel\n@kernel\ndef inner(x):\n    return x + x\n"
    )
    (tmp_path / "sample.py").write_text(
        "from firmware.numerics.dialect import kernel\nfrom beside import inner\n"
        '@kernel("float32(float32)")\ndef outer(x):\n    return inner(x)\n'
    )
    program = (
        f"import sys; sys.path.insert(0, {str(tmp_path)!r}); from sample import outer; print(outer(5.0))"
    )
    cache = {"XDG_CACHE_HOME": str(tmp_path / "cache")}
    assert output(run(program, copy, **cache)) == "10.0"
    change(tmp_path / "beside.py", "x + x", "x * x")
    assert output(run(program, copy, **cache)) == "25.0"


def test_kernel_without_a_file_is_not_kept(copy, tmp_path):
    program = (
        "from firmware.numerics.dialect import kernel\nprint(kernel('int64(int64)')(lambda x: x + 1)(2))"
    )
    assert output(run(program, copy, XDG_CACHE_HOME=str(tmp_path))) == "3"


def test_other_users_of_numba_keep_their_own_cache(copy, tmp_path):
    program = "import numba; from firmware.sample.outer import outer; print(repr(numba.config.CACHE_DIR))"
    assert output(run(program, copy, XDG_CACHE_HOME=str(tmp_path), NUMBA_CACHE_DIR="")) == "''"


def test_unusable_cache_home_falls_back_to_the_next_place(tmp_path, monkeypatch):
    blocked = tmp_path / "file"
    blocked.touch()
    monkeypatch.setenv("XDG_CACHE_HOME", str(blocked))
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    folder = cache_folder.kernel_cache_folder("versions")
    assert folder is not None
    assert folder.is_relative_to(tmp_path / "home" / ".cache" / "navtwin")


def test_no_place_at_all_means_no_cache(tmp_path, monkeypatch):
    blocked = tmp_path / "file"
    blocked.touch()
    for name in ("XDG_CACHE_HOME", "HOME"):
        monkeypatch.setenv(name, str(blocked))
    monkeypatch.setattr(cache_folder.tempfile, "gettempdir", lambda: str(blocked))
    assert cache_folder.kernel_cache_folder("versions") is None


def test_a_folder_that_others_may_write_to_is_refused(tmp_path, monkeypatch):
    """Its files would be executed."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "open"))
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    (tmp_path / "open" / "navtwin" / "kernels").mkdir(parents=True)
    (tmp_path / "open" / "navtwin").chmod(stat.S_IRWXU | stat.S_IRWXO)
    folder = cache_folder.kernel_cache_folder("versions")
    assert folder is not None
    assert folder.is_relative_to(tmp_path / "home")


def test_old_folders_are_dropped_and_the_one_in_use_stays(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    folders = [cache_folder.kernel_cache_folder(str(n)) for n in range(cache_folder.FOLDERS_KEPT + 5)]
    for age, folder in enumerate(reversed(folders)):
        if folder.exists():
            os.utime(folder, (1e9 - age, 1e9 - age))
    newest = cache_folder.kernel_cache_folder("newest")
    kept = list(newest.parent.iterdir())
    assert newest in kept
    assert len(kept) == cache_folder.FOLDERS_KEPT
