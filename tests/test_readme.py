"""What the README says can be done can be done, and its tables are complete."""

import re
import runpy
import shlex
import tomllib
from pathlib import Path

import pytest
from typer.testing import CliRunner

from stribeck.arm import load_arm, save_arm
from stribeck.cli import app
from stribeck.effects.registry import laws, registry
from stribeck.run import save_run

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


def test_every_layer_is_in_the_picture() -> None:
    contracts = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["importlinter"][
        "contracts"
    ]
    layers = next(contract["layers"] for contract in contracts if contract.get("containers") == ["stribeck"])
    named = {part.strip() for layer in layers for part in re.split("[:|]", layer)}
    drawn = re.search(r"```\n(errors.*?)```", (ROOT / "README.md").read_text(encoding="utf-8"), re.DOTALL)
    assert drawn is not None
    assert named - {"__main__"} == set(re.findall(r"\w+", drawn[1]))
