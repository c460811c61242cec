"""Outputs appear whole or not at all."""

import os
import stat
from pathlib import Path

import pytest

from stribeck.errors import InputError
from stribeck.outputs import check_free, whole_file, whole_folder


class Crash(BaseException):
    """Stands for Ctrl-C and everything else that is not an Exception."""


def test_folder_appears_at_the_end(tmp_path: Path) -> None:
    out = tmp_path / "deep" / "out"
    with whole_folder(out) as part:
        (part / "a.txt").write_text("a")
        assert not out.exists()
    assert (out / "a.txt").read_text() == "a"
    assert os.listdir(out.parent) == ["out"]
    assert stat.S_IMODE(out.stat().st_mode) & 0o055 == 0o055 & ~current_umask()


def test_folder_leaves_nothing_on_failure(tmp_path: Path) -> None:
    with pytest.raises(Crash), whole_folder(tmp_path / "deep" / "out") as part:
        (part / "a.txt").write_text("a")
        raise Crash
    assert os.listdir(tmp_path) == []


def test_empty_folder_may_exist_and_survives_failure(tmp_path: Path) -> None:
    out = tmp_path / "out"
    out.mkdir()
    with pytest.raises(Crash), whole_folder(out):
        raise Crash
    assert os.listdir(tmp_path) == ["out"]
    with whole_folder(out) as part:
        (part / "a").touch()
    assert os.listdir(out) == ["a"]


@pytest.mark.parametrize("kind", ["full folder", "file", "below a file"])
def test_folder_refuses_what_is_there(tmp_path: Path, kind: str) -> None:
    out = tmp_path / "out"
    if kind == "full folder":
        out.mkdir()
        (out / "mine.txt").touch()
    else:
        out.touch()
    target = out / "deeper" / "still" if kind == "below a file" else out
    with pytest.raises(InputError), whole_folder(target):
        pytest.fail("the block must not run")
    assert os.listdir(tmp_path) == ["out"]
    if kind != "below a file":
        with pytest.raises(InputError):
            check_free(out)


def test_file_is_replaced_only_when_whole(tmp_path: Path) -> None:
    path = tmp_path / "x.csv"
    path.write_text("old")
    with pytest.raises(Crash), whole_file(path) as part:
        part.write_text("half")
        raise Crash
    assert path.read_text() == "old"
    with whole_file(path) as part:
        part.write_text("new")
        assert path.read_text() == "old"
    assert path.read_text() == "new"
    assert os.listdir(tmp_path) == ["x.csv"]
    assert stat.S_IMODE(path.stat().st_mode) == 0o666 & ~current_umask()


def test_file_leaves_no_new_folders_on_failure(tmp_path: Path) -> None:
    with pytest.raises(Crash), whole_file(tmp_path / "a" / "b" / "x.csv"):
        raise Crash
    assert os.listdir(tmp_path) == []


def test_file_refuses_a_folder(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="a folder"), whole_file(tmp_path):
        pytest.fail("the block must not run")


def current_umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask
