"""Compiled once: the cache, several processes at a time, and compilers that fail."""

import os
import platform
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from stribeck import compiler
from stribeck.errors import StribeckError

SOURCE = "double answer(void) { return 42.0; }\n"


@pytest.fixture
def _fresh(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("STRIBECK_CC", raising=False)
    compiler.compiler.cache_clear()


@pytest.mark.usefixtures("_fresh")
def test_second_build_is_the_first(tmp_path: Path) -> None:
    first = compiler.build(SOURCE, tmp_path)
    stamp = first.stat().st_mtime_ns
    assert compiler.build(SOURCE, tmp_path) == first
    assert first.stat().st_mtime_ns == stamp
    assert compiler.build(SOURCE + "int other;\n", tmp_path) != first
    assert {path.suffix for path in tmp_path.iterdir()} == {".so"}


@pytest.mark.usefixtures("_fresh")
def test_builds_side_by_side(tmp_path: Path) -> None:
    with ThreadPoolExecutor(4) as pool:
        paths = set(pool.map(lambda _: compiler.build(SOURCE, tmp_path), range(4)))
    assert len(paths) == 1
    assert len(list(tmp_path.iterdir())) == 1


def test_processes_side_by_side(tmp_path: Path) -> None:
    code = "from pathlib import Path; from stribeck.compiler import build; import sys, ctypes; "
    code += "lib = ctypes.CDLL(str(build(sys.argv[1]))); lib.answer.restype = ctypes.c_double; print(lib.answer())"
    environment = {**os.environ, "STRIBECK_CACHE": str(tmp_path / "cache")}
    runs = [
        subprocess.Popen([sys.executable, "-c", code, SOURCE], env=environment, stdout=subprocess.PIPE, text=True)
        for _ in range(2)
    ]
    assert [run.communicate(timeout=60)[0].strip() for run in runs] == ["42.0", "42.0"]
    assert len(list((tmp_path / "cache").iterdir())) == 1


@pytest.mark.usefixtures("_fresh")
def test_a_failing_compiler_is_one_line(tmp_path: Path) -> None:
    with pytest.raises(StribeckError, match="C compiler failed"):
        compiler.build("this is no C\n", tmp_path)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("command", ["/does/not/exist", "false"])
def test_a_missing_compiler_is_one_line(command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("STRIBECK_CC", command)
    compiler.compiler.cache_clear()
    with pytest.raises(StribeckError, match="C compiler") as caught:
        compiler.build(SOURCE, tmp_path)
    assert "\n" not in str(caught.value)
    compiler.compiler.cache_clear()


@pytest.mark.skipif(not hasattr(os, "getuid"), reason="no owners and groups there")
def test_a_cache_open_to_others_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Whoever can write there could have us run their code."""
    shared = tmp_path / "shared"
    shared.mkdir()
    shared.chmod(0o777)
    monkeypatch.setenv("STRIBECK_CACHE", str(shared))
    with pytest.raises(StribeckError, match="closed to others"):
        compiler.cache_folder()


@pytest.mark.usefixtures("_fresh")
def test_another_kind_of_machine_builds_its_own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """They may share a home."""
    compiler._identity.cache_clear()
    first = compiler.build(SOURCE, tmp_path)
    monkeypatch.setattr(platform, "machine", lambda: "abacus")
    compiler._identity.cache_clear()
    assert compiler.build(SOURCE, tmp_path) != first
    monkeypatch.undo()
    compiler._identity.cache_clear()


@pytest.mark.skipif(not hasattr(os, "getuid"), reason="no owners and groups there")
def test_a_home_that_cannot_be_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As in a container: the cache is beside the temporary files. A folder that was asked for is no other."""
    (tmp_path / "file").touch()
    monkeypatch.delenv("STRIBECK_CACHE", raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    assert compiler.cache_folder() == tmp_path / f"stribeck-{os.getuid()}"
    monkeypatch.setenv("STRIBECK_CACHE", str(tmp_path / "file" / "cache"))
    with pytest.raises(StribeckError, match="set STRIBECK_CACHE"):
        compiler.cache_folder()


@pytest.mark.slow
def test_zig_builds_too(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where the machine has no compiler."""
    monkeypatch.setenv("STRIBECK_CC", f"{sys.executable} -m ziglang cc")
    compiler.compiler.cache_clear()
    assert compiler.build(SOURCE, tmp_path).exists()
    compiler.compiler.cache_clear()
