"""What lies in an exported FMU: description, documentation, sources, licences; the same bytes every time."""

import subprocess
import xml.etree.ElementTree as ElementTree
import zipfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest
from fmpy import read_model_description
from fmpy.validation import validate_fmu

from stribeck.arm import Arm, EffectEntry, Friction, Joint, load_arm, save_arm
from stribeck.cli import main
from stribeck.errors import InputError
from stribeck.export import PLATFORMS, export_fmu
from stribeck.export.build import _undated
from stribeck.export.documents import identifier_of
from stribeck.export.export import describe, documents
from stribeck.export.notes import notes_of
from stribeck.export.units import unit_of
from stribeck.export.universal import universal

from .conftest import two_links
from .driver import Fmu
from .test_sanitised import sources_of


def test_no_problems(nominal: Fmu) -> None:
    assert validate_fmu(str(nominal.path)) == []


def test_names_of_the_contract(nominal: Fmu) -> None:
    wanted = [
        f"{key}[{j}]" for key in ("tau", "q", "dq", "tau_friction", "sliding", "q_start", "dq_start") for j in (1, 2)
    ]
    wanted += ["joint[1].mass", "joint[2].com[1]", "joint[1].friction.C0", "joint[2].friction.alpha"]
    assert set(wanted) <= set(nominal.vr)


def test_one_prismatic_axis_has_its_own_units() -> None:
    friction = Friction(4.0, 1.0, 2.0, 0.01)
    arm = Arm("axis", (0.0, 0.0), (Joint("X", "prismatic", 0.0, 3.0, (0.0, 0.0), 0.0, 1.0, friction, friction),))
    _, table, _ = describe(arm, 3)
    units = {v.name: v.unit.name for v in table.variables if v.unit}
    assert units["tau[1]"] == units["joint[1].friction.C0"] == "N"
    assert (units["q[1]"], units["dq[1]"], units["der(joint[1].dq)"]) == ("m", "m/s", "m/s2")
    assert units["joint[1].friction.C2"] == "N.s/m"


def test_what_acts_at_the_start_alone_is_fixed() -> None:
    """All else can be tuned, a delay too, which acts outside of the equations."""
    values = {
        "history": {"change": 0.3, "time": 20.0, "start": 0.1, "kept": 0.4},
        "dwell_time": {"rise": 1.0, "time": 1.0, "distance": 0.1, "start": 0.5},
        "delay": {"time": 0.004},
    }
    _, table, _ = describe(two_links(*(EffectEntry(name, ("A",), {"A": own}) for name, own in values.items())), 3)
    fixed = [v.name for v in table.variables if v.causality == "parameter" and v.variability != "tunable"]
    starts = [f"{key}[{j}]" for key in ("q_start", "dq_start") for j in (1, 2)]
    assert fixed == ["effect.history[1].start", "effect.history[1].kept", "effect.dwell_time[1].start", *starts]


@pytest.mark.parametrize(
    ("text", "name", "powers"),
    [
        ("N m s/rad", "N.m.s/rad", {"kg": 1, "m": 2, "s": -1, "rad": -1}),
        ("kg m^2", "kg.m2", {"kg": 1, "m": 2}),
        ("N m s^2/rad^2", "N.m.s2/rad2", {"kg": 1, "m": 2, "rad": -2}),
        ("1/rad", "1/rad", {"rad": -1}),
        ("1", "1", {}),
        ("Hz", "Hz", {"s": -1}),
    ],
)
def test_units(text: str, name: str, powers: dict[str, int]) -> None:
    unit = unit_of(text)
    assert unit.name == name
    assert dict(unit.powers or ()) == powers
    assert unit_of("N m/rad^1.5").powers is None


def test_structure_says_what_depends_on_what() -> None:
    """The stuck-slip coupling is there, and what cannot depend does not."""
    description, table, _ = describe(two_links(), 3)
    names = {v.vr: v.name for v in table.variables}
    found = {names[u.vr]: {names[d] for d in u.dependencies} for u in description.structure.derivatives}
    assert found["der(joint[1].q)"] == {"joint[1].dq"}
    assert {"tau[1]", "tau[2]", "joint[2].q", "joint[1].dq", "joint[2].dq"} <= found["der(joint[1].dq)"]
    assert "time" not in found["der(joint[1].dq)"]
    outputs = {names[u.vr]: {names[d] for d in u.dependencies} for u in description.structure.outputs}
    assert outputs["q[1]"] == {"joint[1].q"}
    initial = {names[u.vr]: {names[d] for d in u.dependencies} for u in description.structure.initial}
    assert initial["q[1]"] == {"q_start[1]"}
    assert {"tau[1]", "q_start[2]", "dq_start[1]", "joint[2].mass", "joint[1].friction.C1"} <= initial["sliding[1]"]


def test_arm_file_and_documentation(nominal: Fmu, tmp_path: Path) -> None:
    with zipfile.ZipFile(nominal.path) as archive:
        archive.extract("resources/arm.toml", tmp_path)
        text = archive.read("documentation/index.html").decode()
        licences = {n for n in archive.namelist() if n.startswith("documentation/licenses/")}
        assert {zipped.date_time[0] for zipped in archive.infolist()} == {1980}
    assert load_arm(tmp_path / "resources/arm.toml") == two_links()
    for word in ("joint[1].friction.C0", "Tustin", "Dormand", "<math", "resources/arm.toml"):
        assert word in text
    assert len(licences) == 2


def test_what_an_fmu_leaves_to_others_is_said(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A limit of the command, in the input's words, and contacts at which an importer's solver may stop."""
    contact = EffectEntry("presliding", ("B",), {"B": {"stiffness": 1e5, "damping": 0.0}}, "maxwell_slip")
    arm = two_links(contact)
    limited = replace(arm, joints=(replace(arm.joints[0], torque_limit=9.0), arm.joints[1]))
    description, table, _ = describe(limited, 2)
    said = {v.name: v.description for v in description.variables}
    assert said["tau[1]"] == "commanded torque of joint A, not cut off at its limit of 9 N m"
    assert said["tau[2]"] == "commanded torque of joint B"
    page = str(documents(description, table, 2)["documentation/index.html"])
    notes = notes_of(table.forward)
    assert notes[0].startswith("the FMU does not cut off the command at torque_limit (A 9 N m)")
    assert notes[1].startswith("B: presliding/maxwell_slip gives way within 0.1 mrad")
    assert all(f"<li>{note}.</li>" in page for note in notes)
    softer = replace(contact, parameters={"B": {"stiffness": 1e4, "damping": 0.0}})
    for other in (softer, replace(contact, law="lugre")):
        assert notes_of(describe(two_links(other), 2)[1].forward) == []
    save_arm(limited, tmp_path / "arm.toml")
    monkeypatch.setattr("stribeck.export.export_fmu", lambda *given, **more: "")
    assert main(["export-fmu", str(tmp_path / "arm.toml"), "--out", str(tmp_path / "arm.fmu")]) == 0
    assert [f"note: {note}" for note in notes] == capsys.readouterr().err.splitlines()[-2:]


def test_version_3_has_terminals_and_a_build_description(nominal3: Fmu) -> None:
    with zipfile.ZipFile(nominal3.path) as archive:
        names = archive.namelist()
        terminals = ElementTree.fromstring(archive.read("terminalsAndIcons/terminalsAndIcons.xml"))
        build = ElementTree.fromstring(archive.read("sources/buildDescription.xml"))
    members = [m.attrib["variableName"] for m in terminals.iter("TerminalMemberVariable")]
    assert members == ["tau[1]", "q[1]", "dq[1]", "tau[2]", "q[2]", "dq[2]"]
    for source in build.iter("SourceFile"):
        assert f"sources/{source.attrib['name']}" in names
    assert "terminalsAndIcons/icon.png" in names


@pytest.mark.parametrize("kind", ["nominal", "controller"])
@pytest.mark.parametrize("fmi", [2, 3])
def test_sources_build_without_a_warning(kind: str, fmi: int, tmp_path: Path) -> None:
    """With any C99 compiler; of the generated part only the unused arguments are warned of."""
    for name, text in sources_of(kind, fmi).items():
        (tmp_path / name).write_text(text)
    flags = ["-std=c99", "-O1", "-fPIC", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-Wno-unused-parameter"]
    flags += ["-Wno-unused-function", "-Wno-cast-function-type", "-Wno-unused-but-set-variable"]
    command = ["gcc", *flags, "-fsyntax-only", f"fmi{fmi}.c"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr[:2000]


def test_linux_binary_needs_an_old_library_only(nominal: Fmu) -> None:
    with zipfile.ZipFile(nominal.path) as archive:
        data = archive.read(next(n for n in archive.namelist() if n.endswith(".so")))
    versions = {
        tuple(map(int, part.split(b"\0")[0].split(b"."))) for part in data.split(b"GLIBC_")[1:] if part[:1].isdigit()
    }
    assert versions
    assert max(versions) <= (2, 17)


def test_the_same_bytes_twice(nominal: Fmu, tmp_path: Path) -> None:
    export_fmu(two_links(), tmp_path / "again.fmu", fmi=nominal.fmi, platforms=["x86_64-linux"])
    assert (tmp_path / "again.fmu").read_bytes() == nominal.path.read_bytes()


def test_names_as_identifiers() -> None:
    assert identifier_of("two-link arm") == "two_link_arm"
    assert identifier_of("7 axes") == "arm_7_axes"
    assert identifier_of("ärm!") == "rm"
    assert identifier_of("???") == "arm"


def test_strange_names_are_escaped() -> None:
    joint = two_links().joints[0]
    from dataclasses import replace

    arm = Arm('a "b" <c> & \\d?', (0.0, 0.0), (replace(joint, name='<"&>'),))
    for fmi in (2, 3):
        description, table, _ = describe(arm, fmi)
        for name, text in documents(description, table, fmi).items():
            if name.endswith(".xml"):
                ElementTree.fromstring(str(text))


def test_a_universal_binary_holds_both() -> None:
    thin = [
        b"\xcf\xfa\xed\xfe" + kind.to_bytes(4, "little") + b"\0" * 4 + bytes(50) for kind in (0x01000007, 0x0100000C)
    ]
    fat = universal(thin)
    assert fat[:8] == b"\xca\xfe\xba\xbe\0\0\0\x02"
    for i, data in enumerate(thin):
        kind, _, offset, size, align = (int.from_bytes(fat[8 + 20 * i + 4 * k :][:4], "big") for k in range(5))
        assert fat[offset : offset + size] == data
        assert kind == int.from_bytes(data[4:8], "little")
        assert offset % (1 << align) == 0
    assert universal(thin[:1]) == thin[0]


def test_wrong_arguments(tmp_path: Path) -> None:
    for arguments in ({"fmi": 4}, {"platforms": ["amiga"]}, {"platforms": []}):
        with pytest.raises(InputError):
            export_fmu(two_links(), tmp_path / "a.fmu", **arguments)
    with pytest.raises(InputError, match=r"\.fmu"):
        export_fmu(two_links(), tmp_path / "a.zip")
    assert list(tmp_path.iterdir()) == []


def test_the_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    save_arm(two_links(), tmp_path / "arm.toml")
    out = tmp_path / "arm.fmu"
    assert main(["export-fmu", str(tmp_path / "arm.toml"), "--out", str(out), "--platforms", "x86_64-linux"]) == 0
    assert read_model_description(out).fmiVersion == "2.0"
    assert main(["export-fmu", str(tmp_path / "arm.toml"), "--out", str(out), "--fmi", "5"]) == 2
    assert "use 2 or 3" in capsys.readouterr().err


def test_what_records_alone_show_is_told_to_be_left_out(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Beside an effect that is none of the FMU's nothing is other than without: no parameter, no law in the page."""
    arm = two_links(EffectEntry("velocity_filter", ("B",), {"B": {"time": 0.03}}))
    save_arm(arm, tmp_path / "arm.toml")
    out = tmp_path / "arm.fmu"
    assert main(["export-fmu", str(tmp_path / "arm.toml"), "--out", str(out), "--platforms", "x86_64-linux"]) == 0
    told = [line for line in capsys.readouterr().err.splitlines() if line.startswith("warning")]
    assert told[0].startswith("warning: B: velocity_filter is of records alone and left out here; it belongs to")
    assert len(told) == 1
    assert list(Fmu(out).vr) == [v.name for v in describe(two_links(), 2)[1].variables]
    with zipfile.ZipFile(out) as archive:
        assert "velocity_filter" not in archive.read("documentation/index.html").decode()


@pytest.mark.parametrize("between", ["joint_flexibility", "backlash"])
def test_a_rotor_that_drives_a_spring_keeps_some_inertia(between: str) -> None:
    values = {"stiffness": 800.0, "damping": 0.5} | ({"gap": 0.01} if between == "backlash" else {})
    table = describe(two_links(EffectEntry(between, ("B",), {"B": values})), 2)[1]
    lower = {v.name: v.lower for v in table.variables if v.name.endswith("rotor_inertia")}
    assert lower == {"joint[1].rotor_inertia": 0.0, "joint[2].rotor_inertia": 1e-6}


@pytest.mark.slow
@pytest.mark.parametrize("fmi", [2, 3])
def test_seven_platforms_in_a_small_file(fmi: int, made: Callable[[Arm, int], Path], tmp_path: Path) -> None:
    export_fmu(two_links(), tmp_path / "a.fmu", fmi=fmi)
    assert (tmp_path / "a.fmu").stat().st_size < 300_000
    with zipfile.ZipFile(tmp_path / "a.fmu") as archive:
        binaries = [n for n in archive.namelist() if n.startswith("binaries/")]
    assert len(binaries) == (len(PLATFORMS) if fmi == 3 else len(PLATFORMS) - 1)
    assert validate_fmu(str(tmp_path / "a.fmu")) == []


def test_windows_binaries_carry_no_date() -> None:
    head = bytearray(b"MZ".ljust(0x80, b"\0") + b"PE\0\0" + bytes(range(40)))
    head[0x3C] = 0x80
    found = _undated(bytes(head))
    assert found[0x88:0x8C] == bytes(4)
    assert found[:0x88] + head[0x88:0x8C] + found[0x8C:] == head
    assert _undated(b"\x7fELF rest") == b"\x7fELF rest"
