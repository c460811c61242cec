"""What the README says can be done can be done, and its tables are complete."""

import re
import runpy
import shlex
import tomllib
from dataclasses import fields
from importlib.resources import files
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from stribeck.arm import Arm, EffectEntry, Friction, Joint, Tolerance, load_arm, save_arm
from stribeck.cli import app
from stribeck.effects.placing import placed_effects
from stribeck.effects.registry import laws, registry
from stribeck.gap.fitted.band import CORNERS, rolled_off
from stribeck.gap.records.prepare import prepare
from stribeck.identify.residual import Residual
from stribeck.model.layout import values_of
from stribeck.model.path import SignalPath
from stribeck.run import load_runs, save_run
from stribeck.simulate import load_loop
from stribeck.simulate.loop import Compensation, JointLoop, Loop, Reference

from .gap.conftest import NOMINAL, recorded

ROOT = Path(__file__).parents[1]
PAGES = [ROOT / name for name in ("README.md", "fmu/README.md", "studies/README.md", "src/stribeck/gap/README.md")]


def commands(page: Path) -> list[str]:
    """Return the lines of a page's shell blocks, without comments."""
    blocks = re.findall(r"```sh\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL)
    return [line.split("#")[0].strip() for block in blocks for line in block.splitlines()]


def rows(page: Path, head: str) -> list[list[str]]:
    """Return the cells of the table whose first column is headed so."""
    lines = page.read_text(encoding="utf-8").splitlines()
    start = next(i for i, line in enumerate(lines) if line.startswith(f"| {head} |"))
    table = []
    for line in lines[start + 2 :]:
        if not line.startswith("|"):
            break
        table.append([cell.strip() for cell in re.split(r"(?<!\\)\|", line)[1:-1]])
    return table


def test_the_two_commands_are_what_ci_types() -> None:
    ci = (ROOT / ".ci/run").read_text(encoding="utf-8").splitlines()
    first, second, *_ = commands(ROOT / "README.md")
    install, diagnose = first.split(" && ")
    assert install in ci
    assert diagnose.replace("--out out", '--out "$work/out"') in ci
    assert [line for line in second.split(" && ") if line not in ci] == []


@pytest.mark.long
def test_the_picture_is_of_the_example_as_it_is() -> None:
    """Its numbers as given, which follow from the recording alone; those corrected take a whole diagnosis."""
    example = files("stribeck") / "example"
    arm = load_arm(str(example / "arm.toml"))
    prepared = prepare(arm, load_runs([str(example / f"run_0{k}.csv") for k in range(6)], arm.n))
    text = " ".join((ROOT / "README.md").read_text(encoding="utf-8").split())
    joints = r"joint A ([\d.]+) N m as given, [\d.]+ N m corrected; joint B ([\d.]+) and [\d.]+ N m"
    told = re.search(joints + r", counted below ([\d.]+) Hz", text)
    assert told is not None
    *given, corner = (float(value) for value in told.groups())
    path = SignalPath(arm, ())
    left = Residual(path, rolled_off(prepared, corner).held, ())(values_of(path.entries))[0]
    assert corner in [pytest.approx(part * prepared.cutoff, rel=5e-3) for part in CORNERS[:-1]]
    assert given == pytest.approx(np.sqrt(np.mean(left**2, axis=0)), rel=5e-3)


@pytest.mark.long
def test_the_python_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.chdir(tmp_path)
    save_arm(NOMINAL, "arm.toml")
    for k, run in enumerate(recorded(("delay", {"time": 0.02}))[:3]):
        save_run(run, f"run_{k}.csv")
    (block,) = re.findall(r"```python\n(.*?)```", (ROOT / "README.md").read_text(encoding="utf-8"), re.DOTALL)
    (tmp_path / "script.py").write_text(block, encoding="utf-8")
    runpy.run_path("script.py")
    verdict, *causes = capsys.readouterr().out.splitlines()
    assert verdict == "explained ('delay',)"
    assert causes[0].startswith("delay ")
    assert load_arm("corrected.toml").effects[0].effect == "delay"


@pytest.mark.long
@pytest.mark.parametrize("page", [ROOT / "README.md", ROOT / "fmu/README.md"], ids=["README", "fmu"])
def test_every_other_command_runs(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """In this order, in a folder that holds an arm, its recordings and the models of ``fmu``."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "fmu").symlink_to(ROOT / "fmu")
    save_arm(NOMINAL, "arm.toml")
    for k, run in enumerate(recorded(("delay", {"time": 0.02}))[:3]):
        save_run(run, f"run_{k}.csv")
    own = [line for line in commands(page) if not line.startswith("pip ")]
    assert own
    for line in own:
        program, *words = shlex.split(line)
        assert program == "stribeck", line
        place = words[words.index("--out") + 1] if "--out" in words else None
        if place is not None:
            Path(place).unlink(missing_ok=True)  # of the line before
        done = CliRunner().invoke(app, words)
        assert done.exit_code == 0, f"{line}\n{done.output}"
        assert place is None or Path(place).exists()


def test_every_command_is_told_of() -> None:
    from typer.main import get_command

    told = " ".join(row[0] for row in rows(ROOT / "README.md", "command"))
    missing = [name for name in get_command(app).commands if f"stribeck {name}" not in told]  # type: ignore[attr-defined]
    assert missing == []


def test_every_effect_has_its_row() -> None:
    told = {re.sub(r"\[`(\w+)`\].*", r"\1", row[0]): row for row in rows(ROOT / "README.md", "effect")}
    assert set(told) == set(registry())
    for name, effect in registry().items():
        stage, parameters = told[name][1], told[name][3]
        assert effect.channel.replace("_", " ") in stage
        said = {f"`{p.name}`" for p in effect.parameters if not p.name[-1].isdigit()}
        assert [p for p in said if p not in parameters] == [], name
        equation = effect.equation.replace("|", r"\vert ")
        assert re.sub(r"\s", "", equation) in re.sub(r"\s", "", told[name][2]), name
    for (name, law), effect in laws().items():
        row = told[name]
        several = sum(family == name for family, _ in laws()) > 1
        assert not several or f"(`{law}`" in row[2], (name, law)
        assert set(re.findall(r"[A-Z][\w-]+ \(\d{4}\)", effect.source)) <= set(
            re.findall(r"[A-Z][\w-]+ \(\d{4}\)", row[5])
        ), (name, law)


@pytest.mark.parametrize("page", [ROOT / "README.md", ROOT / "studies/README.md"], ids=["short", "full"])
def test_every_study_has_its_row(page: Path) -> None:
    studies = {f"`{path.name}`" for path in (ROOT / "studies").glob("[!_]*.py")}
    assert {row[0] for row in rows(page, "study")} == studies


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.parent.name)
def test_links_lead_somewhere(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    for target in re.findall(r"\]\((?!https?:)([^)\s]+)\)", text):
        file, _, anchor = target.partition("#")
        place = page.parent / file if file else page
        assert place.exists(), target
        if anchor:
            heads = re.findall(r"^#+ (.*)$", place.read_text(encoding="utf-8"), re.MULTILINE)
            assert anchor in {re.sub(r"[^\w\- ]", "", head.lower()).replace(" ", "-") for head in heads}, target


def examples() -> tuple[str, str]:
    """Return the README's arm file and loop file."""
    arm, loop = re.findall(r"```toml\n(.*?)```", (ROOT / "README.md").read_text(encoding="utf-8"), re.DOTALL)
    return arm, loop


def test_the_annotated_files_load(tmp_path: Path) -> None:
    arm, loop = tmp_path / "arm.toml", tmp_path / "loop.toml"
    for path, text in zip((arm, loop), examples(), strict=True):
        path.write_text(text, encoding="utf-8")
    read = load_arm(arm)
    assert len(placed_effects(read)) == 1
    assert load_loop(loop, read).clamp == {"B": 0.5}


def test_the_annotated_files_have_every_key_with_its_default() -> None:
    arm, loop = map(tomllib.loads, examples())
    joint, controller = arm["joints"][0], loop["joints"][0]
    tables: list[tuple[type, dict[str, object]]] = [
        (Arm, arm),
        (Tolerance, arm["tolerance"]),
        (Joint, joint | joint["friction"]),  # which has those backward
        (Friction, joint["friction"]),
        (EffectEntry, arm["effects"][0]),
        (Loop, loop),
        (JointLoop, controller),
        (Compensation, controller["compensation"]),
        (Reference, controller["reference"]),
    ]
    assert [(kind, key.name) for kind, table in tables for key in fields(kind) if key.name not in table] == []
    defaults = {(key.name, repr(key.default)) for kind, _ in tables for key in fields(kind)}
    stated = re.findall(r"^(\w+) = .*; default ([^;:\n]+)$", "".join(examples()), re.MULTILINE)
    read = [(key, tomllib.loads(f"x = {value}")["x"]) for key, value in stated if key != "B"]
    assert len(read) > 20
    wrong = [
        pair
        for pair in read
        if (pair[0], repr(tuple(pair[1]) if isinstance(pair[1], list) else pair[1])) not in defaults
    ]
    assert wrong == []


@pytest.mark.parametrize("command", ["simulate", "limit-cycle"])
def test_the_help_says_where_the_formats_stand(command: str) -> None:
    told = " ".join(re.sub(r"[^\w./ ]", " ", CliRunner().invoke(app, [command, "--help"]).output).split())
    heads = re.findall(r"^## (.*)$", (ROOT / "README.md").read_text(encoding="utf-8"), re.MULTILINE)
    assert [head for head in ("The arm file", "The loop file") if head not in told or head not in heads] == []
    assert "fmu/two_link_nominal/arm.toml" in told


def test_every_layer_is_in_the_picture() -> None:
    contracts = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["importlinter"][
        "contracts"
    ]
    layers = next(contract["layers"] for contract in contracts if contract.get("containers") == ["stribeck"])
    named = {part.strip() for layer in layers for part in re.split("[:|]", layer)}
    drawn = re.search(r"```\n(errors.*?)```", (ROOT / "README.md").read_text(encoding="utf-8"), re.DOTALL)
    assert drawn is not None
    assert named - {"__main__"} == set(re.findall(r"\w+", drawn[1]))
