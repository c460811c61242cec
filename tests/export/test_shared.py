"""What the FMUs of arms and controllers share: the token, the standard's functions, the places of the binaries."""

import struct

import pytest

from stribeck.errors import InputError
from stribeck.export.build import PLATFORMS, Platform
from stribeck.export.shared import check_version, compiled, stamped

MODEL = "#ifndef FM_MODEL_H\n#define FM_MODEL_H\n"


def thin(sources: object, main: str, identifier: str, platform: Platform) -> bytes:
    """The head of a 64-bit Mach-O file, its processor that of the platform."""
    processor = 0x01000007 if platform.name.startswith("x86") else 0x0100000C
    return struct.pack("<III", 0xFEEDFACF, processor, 0).ljust(64, b"\0")


def test_every_platform_has_its_place(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("stribeck.export.shared.binary", thin)
    three = compiled({"fmi3.c": ""}, "it", 3, PLATFORMS)
    assert set(three) == {"sources/fmi3.c"} | {f"binaries/{p.name}/it{p.suffix}" for p in PLATFORMS}


def test_version_2_has_one_file_for_both_processors_of_macos(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("stribeck.export.shared.binary", thin)
    content = compiled({"fmi2.c": ""}, "it", 2, PLATFORMS)
    assert len(content) == 1 + len(PLATFORMS) - 1
    fat = content["binaries/darwin64/it.dylib"]
    assert isinstance(fat, bytes)
    magic, count, first, second = (struct.unpack_from(">I", fat, at)[0] for at in (0, 4, 8, 28))
    assert (magic, count, {first, second}) == (0xCAFEBABE, 2, {0x01000007, 0x0100000C})


@pytest.mark.parametrize("fmi", [2, 3])
def test_token_is_that_of_everything_compiled(fmi: int) -> None:
    token, texts = stamped(MODEL, {"part.h": "int a;\n"}, fmi)
    assert texts["model.h"] == f'{MODEL}#define FM_TOKEN "{token}"\n#endif\n'
    assert {"both.h", "part.h", f"fmi{fmi}.c", f"fmi{fmi}Functions.h"} < set(texts)
    assert stamped(MODEL, {"part.h": "int a;\n"}, fmi) == (token, texts)
    assert stamped(MODEL, {"part.h": "int b;\n"}, fmi)[0] != token
    assert stamped(MODEL + "int b;\n", {"part.h": "int a;\n"}, fmi)[0] != token


def test_other_versions_are_refused() -> None:
    with pytest.raises(InputError, match="unknown version of FMI: found 1; use 2 or 3"):
        check_version(1)
