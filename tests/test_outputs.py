"""Outputs appear whole or not at all."""

import errno
import os
import stat
from collections.abc import Callable
from contextlib import AbstractContextManager
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


def test_a_link_to_an_empty_folder_stays_a_link(tmp_path: Path) -> None:
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "out").symlink_to("elsewhere")
    with whole_folder(tmp_path / "out") as part:
        (part / "a").touch()
    assert os.readlink(tmp_path / "out") == "elsewhere"
    assert os.listdir(tmp_path / "elsewhere") == ["a"]
    assert sorted(os.listdir(tmp_path)) == ["elsewhere", "out"]


def test_the_current_folder_may_be_given(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "out").mkdir()
    monkeypatch.chdir(tmp_path / "out")
    with whole_folder(".") as part:
        (part / "a").touch()
    assert os.listdir(tmp_path / "out") == ["a"]


@pytest.mark.parametrize("links", ["nowhere", "out"])
def test_a_link_to_nothing_is_refused(tmp_path: Path, links: str) -> None:
    (tmp_path / "out").symlink_to(links)
    with pytest.raises(InputError, match="out: output folder cannot be made"), whole_folder(tmp_path / "out"):
        pytest.fail("the block must not run")
    assert os.listdir(tmp_path) == ["out"]


@pytest.mark.parametrize("kind", ["full folder", "file"])
def test_who_comes_second_is_told(tmp_path: Path, kind: str) -> None:
    """Another program has made the folder meanwhile: its result stays, and the other leaves nothing."""
    out = tmp_path / "out"
    with pytest.raises(InputError, match=r"out: cannot be written: found .*; give another place"):  # noqa: SIM117
        with whole_folder(out) as part:
            (part / "a").touch()
            if kind == "file":
                out.touch()
            else:
                out.mkdir()
                (out / "theirs").touch()
    assert os.listdir(tmp_path) == ["out"]
    assert kind == "file" or os.listdir(out) == ["theirs"]


@pytest.mark.parametrize("whole", [whole_folder, whole_file])
def test_a_full_disk_is_told(tmp_path: Path, whole: Callable[[Path], AbstractContextManager[Path]]) -> None:
    with (
        pytest.raises(InputError, match="out: cannot be written: found no space left on device"),
        whole(tmp_path / "deep" / "out"),
    ):
        raise OSError(errno.ENOSPC, "No space left on device")
    assert os.listdir(tmp_path) == []


def test_a_file_is_written_where_its_link_points(tmp_path: Path) -> None:
    (tmp_path / "true.csv").write_text("old")
    (tmp_path / "x.csv").symlink_to("true.csv")
    with whole_file(tmp_path / "x.csv") as part:
        part.write_text("new")
    assert (tmp_path / "x.csv").is_symlink()
    assert (tmp_path / "true.csv").read_text() == "new"


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
