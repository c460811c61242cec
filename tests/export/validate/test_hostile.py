"""Archives that want to do harm, or are none: refused in one line, in bounded memory, with nothing left behind."""

import io
import os
import struct
import tracemalloc
import zipfile
from collections.abc import Callable
from pathlib import Path

import pytest

from stribeck.cli import main
from stribeck.errors import InputError
from stribeck.export.validate import check_fmu, validate_fmu

from .tiny import DESCRIPTION, tiny


def raw(path: Path, *entries: tuple[zipfile.ZipInfo | str, bytes]) -> Path:
    """An archive with a sound description and entries as given."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("modelDescription.xml", DESCRIPTION)
        for entry, data in entries:
            archive.writestr(entry, data)
    return path


def link(name: str, target: str) -> tuple[zipfile.ZipInfo, bytes]:
    entry = zipfile.ZipInfo(name)
    entry.create_system, entry.external_attr = 3, 0o120777 << 16
    return entry, target.encode()


def patched(path: Path, old: bytes, new: bytes) -> Path:
    """Names in an archive, changed after zipfile has had its say."""
    assert len(old) == len(new)
    path.write_bytes(path.read_bytes().replace(old, new))
    return path


def bomb(path: Path, size: int = 2 << 30) -> Path:
    """A file of zeros whose unpacked size the archive tells truly."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive:
        archive.writestr("modelDescription.xml", DESCRIPTION)
        with archive.open("zeros", "w", force_zip64=False) as out:
            for _ in range(64):
                out.write(bytes(1 << 20))
    data = bytearray(path.read_bytes())
    at = data.rindex(b"PK\1\2")
    struct.pack_into("<I", data, at + 24, size)
    path.write_bytes(bytes(data))
    return path


def slab(path: Path) -> Path:
    """Zeros that bzip2 packs into a few bytes, said to be few as well: they come in one stretch."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("modelDescription.xml", DESCRIPTION)
        archive.writestr("zeros", bytes(64 << 20), zipfile.ZIP_BZIP2)
    return patched(path, struct.pack("<I", 64 << 20), struct.pack("<I", 1000))


def liar(path: Path) -> Path:
    """64 MiB that the archive says are 10 bytes."""
    return bomb(path, 10)


def long_directory(path: Path) -> Path:
    """The closing record announces a directory of 1 GiB."""
    data = bytearray(raw(path).read_bytes())
    struct.pack_into("<I", data, data.rindex(b"PK\5\6") + 12, 1 << 30)
    path.write_bytes(bytes(data))
    return path


def zip64(path: Path) -> Path:
    data = raw(path).read_bytes()
    at = data.rindex(b"PK\5\6")
    path.write_bytes(data[:at] + b"PK\6\7" + bytes(16) + data[at:])
    return path


def encrypted(path: Path) -> Path:
    data = bytearray(raw(path, ("a", b"a")).read_bytes())
    data[data.rindex(b"PK\1\2") + 8] |= 1
    path.write_bytes(bytes(data))
    return path


def described(text: str | bytes) -> Callable[[Path], Path]:
    def make(path: Path) -> Path:
        buffer = io.BytesIO()
        with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
            archive.writestr("modelDescription.xml", text)
        path.write_bytes(buffer.getvalue())
        return path

    return make


def content(data: bytes) -> Callable[[Path], Path]:
    def make(path: Path) -> Path:
        path.write_bytes(data)
        return path

    return make


def cut_short(path: Path) -> Path:
    return content(raw(path).read_bytes()[:-30])(path)


LAUGHS = "".join(f'<!ENTITY l{i + 1} "{f"&l{i};" * 10}">' for i in range(9))
BOMB = f'<?xml version="1.0"?><!DOCTYPE x [<!ENTITY l0 "ha">{LAUGHS}]><fmiModelDescription modelName="&l9;"/>'
OUTSIDE = '<?xml version="1.0"?><!DOCTYPE x [<!ENTITY e SYSTEM "file:///etc/passwd">]><fmiModelDescription>&e;</fmiModelDescription>'
BLIND = BOMB.replace('<?xml version="1.0"?>', '<?xml version="1.0" encoding="UTF-16"?>').encode("utf-16")

HOSTILE: dict[str, tuple[Callable[[Path], Path], str]] = {
    "zip slip": (lambda path: raw(path, ("../evil", b"x")), "entry '../evil' leaves the archive with '..'"),
    "deep slip": (lambda path: raw(path, ("a/b/../../../evil", b"x")), "leaves the archive with '..'"),
    "backslash slip": (lambda path: patched(raw(path, ("aaa/evil", b"x")), b"aaa/evil", b"..\\evilx"), "with '..'"),
    "absolute": (lambda path: raw(path, ("/tmp/evil", b"x")), "has an absolute path"),
    "drive": (lambda path: raw(path, ("C:/evil", b"x")), "has an absolute path"),
    "nul": (lambda path: patched(raw(path, ("evil.txt", b"x")), b"evil.txt", b"evil\0txt"), "has no proper name"),
    "link": (lambda path: raw(path, link("resources", "/")), "entry 'resources' is a link or a device"),
    "through a link": (lambda path: raw(path, link("a", "/tmp"), ("a/evil", b"x")), "is a link or a device"),
    "file as folder": (lambda path: raw(path, ("a", b"x"), ("a/b", b"x")), "a file where another entry has a folder"),
    "twins": (lambda path: raw(path, ("a", b"x"), ("A", b"y")), "has two entries of one name"),
    "long name": (lambda path: raw(path, ("a" * 5000, b"x")), "has an absurdly long name"),
    "encrypted": (encrypted, "entry 'a' is encrypted"),
    "bomb": (bomb, "unpacks to too much for an FMU: found 2048 MiB; at most 1024 MiB"),
    "slab": (slab, "entry 'zeros' is packed in no usual way: found method 12; pack it by deflate"),
    "lying size": (liar, "not a sound zip archive: found Bad CRC-32"),
    "long directory": (long_directory, "has too many files for an FMU: found a list of entries of 1024 MiB"),
    "zip64": (zip64, "a zip64 archive"),
    "empty": (content(b""), "not an FMU: found no zip archive"),
    "text": (content(b"hello"), "not an FMU: found no zip archive"),
    "cut short": (cut_short, "no zip archive"),
    "damaged": (lambda path: patched(raw(path), b"PK\1\2", b"PK\1\3"), "not a sound zip archive"),
    "no description": (
        lambda path: patched(raw(path), b"modelDescription", b"modelDescripTion"),
        "no modelDescription",
    ),
    "missing": (lambda path: path, "cannot be read: found no such file or directory"),
    "entity bomb": (described(BOMB), "declares a document type, which could hide entities"),
    "outer entity": (described(OUTSIDE), "declares a document type"),
    "bomb in UTF-16": (described(BLIND), "declares a document type"),
    "not XML": (described("hello"), "is not well-formed XML"),
    "unknown encoding": (described('<?xml version="1.0" encoding="x"?><a/>'), "is not well-formed XML"),
    "other XML": (described("<html/>"), "describes no FMU: found <html>"),
    "deep XML": (described("<fmiModelDescription>" * 5000), "is nested too deeply"),
    "wide XML": (described(f"<fmiModelDescription>{'<a/>' * 600_000}</fmiModelDescription>"), "too many elements"),
    "long XML": (described(b" " * (17 << 20)), "is too large: found 17 MiB"),
    "long attribute": (described(f'<fmiModelDescription modelName="{"a" * 70_000}"/>'), "has an absurd attribute"),
    "long variable": (described(f'<fmiModelDescription><v name="{"a" * 1001}"/></fmiModelDescription>'), "long name"),
}


@pytest.mark.parametrize("name", HOSTILE)
def test_refused(tmp_path: Path, name: str) -> None:
    make, says = HOSTILE[name]
    path = make(tmp_path / "model.fmu")
    before = sorted(os.listdir(tmp_path))
    with pytest.raises(InputError) as refusal:
        check_fmu(path)
    assert says in str(refusal.value)
    assert str(refusal.value).startswith(str(path))
    assert "\n" not in str(refusal.value)
    assert sorted(os.listdir(tmp_path)) == before
    assert not Path("/tmp/evil").exists()


@pytest.mark.parametrize("name", ["bomb", "slab", "lying size", "long directory", "entity bomb", "long XML"])
def test_memory_stays_small(tmp_path: Path, name: str) -> None:
    path = HOSTILE[name][0](tmp_path / "model.fmu")
    tracemalloc.start()
    try:
        with pytest.raises(InputError):
            check_fmu(path)
        assert tracemalloc.get_traced_memory()[1] < 40 << 20
    finally:
        tracemalloc.stop()


def test_command_refuses_with_status_2(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = raw(tmp_path / "model.fmu", ("../evil", b"x"))
    assert main(["validate-fmu", str(path)]) == 2
    captured = capsys.readouterr()
    assert captured.err == f"stribeck: {path}: entry '../evil' leaves the archive with '..'; do not trust this file\n"
    assert captured.out == ""


def test_command_lists_problems_with_status_1(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    sound = tiny(tmp_path / "sound.fmu")
    assert main(["validate-fmu", str(sound)]) == 0
    assert "no problems" in capsys.readouterr().out
    twins = tiny(tmp_path / "twins.fmu", description=DESCRIPTION.replace('name="u"', 'name="x"'))
    assert main(["validate-fmu", str(twins), "--no-run"]) == 1
    captured = capsys.readouterr()
    assert "is not unique" in captured.out
    assert captured.err == ""


def test_backslashes_are_a_problem(tmp_path: Path) -> None:
    path = patched(tiny(tmp_path / "model.fmu", {"docs/aa": b"x"}), b"docs/aa", b"docs\\aa")
    assert any("has a backslash" in problem for problem in validate_fmu(path, run=False))
