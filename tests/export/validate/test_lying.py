"""FMUs that are not what they say: named, each in one line, and nothing takes the checker down with it."""

import os
import time
import zipfile
from collections.abc import Callable
from pathlib import Path

import pytest

from stribeck.errors import StribeckError
from stribeck.export.validate import check_fmu, validate_fmu
from stribeck.export.validate.apart import Trial, simulate_apart

from .tiny import CRASH, DESCRIPTION, ERROR, EXIT, HANG, HERE, MEMORY, NAN, RANDOM, VERSION, binary, source, tiny


def test_sound_one_has_no_problems_and_says_what_was_left_out(tmp_path: Path) -> None:
    found = check_fmu(tiny(tmp_path / "tiny.fmu"))
    assert found.problems == ()
    assert found.facts[0] == "FMI 2.0, CoSimulation, by by hand"
    assert any("holds no resources/arm.toml" in text for text in found.skipped)
    assert any("without a unit" in text for text in found.skipped)


def test_one_that_cannot_be_run_here_is_not_called_sound(tmp_path: Path) -> None:
    path = tmp_path / "tiny.fmu"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("modelDescription.xml", DESCRIPTION)
        archive.writestr("sources/tiny.c", "int lag;")  # how to build it is not said
    assert validate_fmu(path, run=False) == []
    (problem,) = validate_fmu(path)
    assert problem.startswith("it could not be run on this machine: no binary in binaries/")


WAYS = {
    CRASH: "Co-Simulation failed while simulating: the binary crashed with SIGSEGV",
    NAN: "CoSimulation gives values of x that are not finite",
    MEMORY: "failed while simulating: FMICallException: fmi2DoStep failed with status 3",
    EXIT: "Co-Simulation failed while simulating: exit status 0",
    ERROR: "fmi2DoStep failed with status 3",
    VERSION: "the binary says FMI 3.0, the description 2.0",
    RANDOM: "CoSimulation gives another result when it is simulated a second time",
}


@pytest.mark.parametrize("way", WAYS)
def test_misbehaving_binary(tmp_path: Path, way: int) -> None:
    (problem,) = validate_fmu(tiny(tmp_path / "tiny.fmu", way=way))
    assert WAYS[way] in problem
    assert "\n" not in problem


@pytest.mark.slow  # it takes all the time that it is given
def test_binary_that_hangs(tmp_path: Path) -> None:
    tiny(tmp_path / "tiny.fmu", way=HANG)
    folder = tmp_path / "unpacked"
    with zipfile.ZipFile(tmp_path / "tiny.fmu") as archive:
        archive.extractall(folder)
    started = time.monotonic()
    with pytest.raises(StribeckError, match="it took longer than 1 s"):
        simulate_apart(Trial(str(folder), "CoSimulation", 1.0, 0.1, ("x",), seconds=1.0))
    assert time.monotonic() - started < 60.0  # it hangs for ever


def replaced(old: str, new: str) -> Callable[[Path], Path]:
    assert old in DESCRIPTION
    return lambda path: tiny(path, description=DESCRIPTION.replace(old, new))


C_FILES = '<CoSimulation modelIdentifier="tiny"><SourceFiles><File name="{}"/></SourceFiles></CoSimulation>'
PLAIN = '<CoSimulation modelIdentifier="tiny" canHandleVariableCommunicationStepSize="true"/>'


def sourced(text: str) -> Callable[[Path], Path]:
    listed = DESCRIPTION.replace(PLAIN, C_FILES.format("tiny.c"))
    return lambda path: tiny(path, {"sources/tiny.c": text}, description=listed)


def further(text: str) -> Callable[[Path], Path]:
    """A source that includes a file, by way of another one, from elsewhere in the FMU."""
    listed = DESCRIPTION.replace(PLAIN, C_FILES.format("d/tiny.c"))
    more = {
        "sources/d/tiny.c": '#include "../a.h"',
        "sources/a.h": '#include "../resources/B.h"',
        "resources/b.h": text,
    }
    return lambda path: tiny(path, more, description=listed)


LIES: dict[str, tuple[Callable[[Path], Path], str]] = {
    "token": (replaced("{tiny}", "{another}"), "Failed to instantiate"),
    "output not listed": (replaced('<Outputs><Unknown index="2"/></Outputs>', ""), "ModelStructure/Outputs"),
    "no such index": (replaced('<Outputs><Unknown index="2"/>', '<Outputs><Unknown index="9"/>'), "index"),
    "twin names": (replaced('name="u"', 'name="x"'), "is not unique"),
    "undeclared unit": (replaced('<Real start="0.5"/>', '<Real start="0.5" unit="kg"/>'), 'unit "kg"'),
    "no start": (replaced('<Real start="0"/>', "<Real/>"), "no start value"),
    "schema": (replaced("<ModelVariables>", "<ModelVariables><Real/>"), "not expected"),
    "identifier": (replaced('modelIdentifier="tiny"', 'modelIdentifier="../../evil"'), "is not a name in C"),
    "other identifier": (replaced('modelIdentifier="tiny"', 'modelIdentifier="other"'), "other.so is missing"),
    "experiment": (replaced('stopTime="0.5"', 'stopTime="soon"'), "DefaultExperiment: stopTime is not a number"),
    "backwards": (replaced('stopTime="0.5"', 'stopTime="-1"'), "DefaultExperiment makes no sense"),
    "another machine": (lambda path: tiny(path, {"binaries/win64/tiny.dll": binary()}), "is built for linux on"),
    "no binary": (lambda path: tiny(path, {"binaries/win32/tiny.dll": b"MZ" + bytes(200)}), "is built for something"),
    "short binary": (lambda path: tiny(path, {"binaries/win32/tiny.dll": b""}), "is not a binary"),
    "function missing": (lambda path: tiny(path, {HERE: binary(0, "fmi2Reset")}), "lacks fmi2Reset"),
    "no source file": (replaced(PLAIN, C_FILES.format("tiny.c")), "source file 'tiny.c' is not in the archive"),
    "source outside": (replaced(PLAIN, C_FILES.format("../../../etc/passwd")), "leaves the FMU"),
    "endless include": (sourced('#include "/dev/zero"'), "sources/tiny.c includes '/dev/zero', which leaves the FMU"),
    "include upwards": (sourced("#  include <../../../x.h>"), "includes '../../../x.h', which leaves the FMU"),
    "include by a macro": (sourced('#define F "/dev/stdin"\n#include F'), "includes 'F', which is no plain name"),
    "include by a trigraph": (sourced('??=inc??/\nlude "/dev/zero"'), "includes '/dev/zero', which leaves the FMU"),
    "include by a digraph": (sourced('/* */ %: include "/dev/zero"'), "includes '/dev/zero', which leaves the FMU"),
    "include by a comment": (sourced('#/**/include "/dev/zero"'), "hides what it asks the preprocessor for"),
    "include of a long name": (sourced(f'#include "/dev/{"./" * 300}zero"'), "which is no plain name of a file"),
    "include further on": (further("#include </dev/zero>"), "resources/b.h includes '/dev/zero', which leaves"),
    "file in assembler": (sourced('__asm__(".incbin \\"/etc/hosts\\"");'), "includes a file by assembler"),
    "embedded file": (sourced('char c[] = {\n#embed "/dev/zero"\n};'), "sources/tiny.c embeds a file"),
    "source as option": (replaced(PLAIN, C_FILES.format("-v")), "leaves the FMU"),
}


RUNNING = ("token", "experiment", "backwards")  # the other lies show without running, which takes two processes


@pytest.mark.parametrize("name", LIES)
def test_lie_is_named(tmp_path: Path, name: str) -> None:
    make, says = LIES[name]
    problems = validate_fmu(make(tmp_path / "tiny.fmu"), run=name in RUNNING)
    assert any(says in problem for problem in problems), problems
    assert not any("\n" in problem for problem in problems)
    assert os.listdir(tmp_path) == ["tiny.fmu"]


def test_sources_are_not_compiled_for_who_does_not_trust_them(tmp_path: Path) -> None:
    listed = DESCRIPTION.replace(PLAIN, C_FILES.format("tiny.c"))
    texts = {
        "sources/tiny.c": '// # include X\n#include "a.h"\n#include <math.h>\n',
        "sources/a.h": "int f(void) { return x; }",
    }
    found = check_fmu(
        tiny(tmp_path / "tiny.fmu", texts | {"sources/CMakeLists.txt": "# include X"}, description=listed), run=False
    )
    assert found.problems == ()
    assert "build of the sources: not asked for" in found.skipped


@pytest.mark.slow  # zig's first build of a target takes a while
def test_sources_are_built_and_run_where_no_binary_is(tmp_path: Path) -> None:
    listed = DESCRIPTION.replace(PLAIN, C_FILES.format("tiny.c"))
    path = tiny(tmp_path / "tiny.fmu", {HERE: b"", "sources/tiny.c": source()}, description=listed)
    assert any("is not a binary" in problem for problem in validate_fmu(path))
    broken = tiny(tmp_path / "broken.fmu", {"sources/tiny.c": "int f(void) { return x; }"}, description=listed)
    assert any("the sources do not build: sources/tiny.c:1:" in problem for problem in validate_fmu(broken))
