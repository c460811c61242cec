"""An effect of another package that is declared wrongly is told in one line, which names the package."""

import math
from collections.abc import Iterator
from importlib.metadata import EntryPoint
from pathlib import Path
from typing import Any

import casadi as ca
import pytest

from stribeck.cli import main
from stribeck.effects.declared import check, declared
from stribeck.effects.registry import laws, registry
from stribeck.errors import InputError
from stribeck.model.effect import ActuatorEffect, Effect
from stribeck.model.values import Parameter

from .bench import every_effect

GAIN = Parameter("doubling", "N m", "torque at which the gain has doubled", math.inf, 1e-3, 1e9, log=True)


class Good(ActuatorEffect):
    """Nothing is wrong with it."""

    name = "my_drive"
    channel = "actuator"
    equation = r"\tau = u (1 + (u/U)^2)"
    symptom = "the cube of the command"
    shows = "command"
    source = "a test"
    parameters = (GAIN,)

    def starts(self, scale: Any) -> tuple[dict[str, float], ...]:
        return ({"doubling": 3.0 * scale.torque},)

    def torque(self, torque: Any, s: Any, x: Any, p: Any) -> Any:
        return torque * (1.0 + (torque / p["doubling"]) ** 2)


def raising(self: object, *given: object) -> Any:
    raise ValueError("oops\nand more")


def bare(*left_out: str) -> type:
    """The class without some of what it declares."""
    kept = {key: value for key, value in vars(Good).items() if key not in left_out and not key.startswith("__")}
    return type("Bare", (ActuatorEffect,), kept)


def other(**changes: Any) -> type:
    return type("Other", (Good,), changes)


def starts(**values: float) -> type:
    return other(starts=lambda self, scale: (values,))


def parameter(**changes: Any) -> type:
    return other(parameters=(Parameter(**{**vars(GAIN), **changes}),))


FAULTS: dict[str, tuple[object, str]] = {
    "no class": ("text", "is no class of an effect: found 'text'"),
    "an instance": (Good(), "is no class of an effect: found <"),
    "a function": (lambda: 3, "is no effect of a stage; its class must be one of ActuatorEffect, "),
    "the base": (type("Base", (Effect,), {"starts": Good.starts}), "is no effect of a stage; its class must be one of"),
    "no starts": (bare("starts"), "cannot be made without arguments: found TypeError: Can't instantiate abstract"),
    "arguments": (other(__init__=lambda self, given: None), "cannot be made without arguments: found TypeError"),
    "no name": (bare("name"), "name is missing"),
    "no channel": (bare("channel"), "channel is missing"),
    "no equation": (bare("equation"), "equation is missing"),
    "no symptom": (bare("symptom"), "symptom is missing"),
    "no source": (bare("source"), "source is missing"),
    "no parameters": (bare("parameters"), "parameters must be a tuple of Parameter"),
    "no comma": (other(parameters=GAIN), "parameters must be a tuple of Parameter; one alone needs a comma behind it"),
    "a name of XML": (other(name="my drive <x>"), "name must be letters and digits, words joined by _: found 'my driv"),
    "channel": (other(channel="motor"), "channel must be one of friction, actuator, transmission, sensing, rigid_body"),
    "shows": (other(shows="foo"), "shows must be one of time, frequency, "),
    "unit": (parameter(unit="Newtonmeter"), "the unit of parameter doubling is not known: found 'Newtonmeter'"),
    "bounds": (parameter(upper=1e-4), "the bounds of parameter doubling are not in order: found 0.001 to 0.0001"),
    "logarithm": (
        parameter(lower=0.0),
        "parameter doubling is fitted in its logarithm; its lower bound must be positive",
    ),
    "delays": (other(delays="command"), "delays needs a parameter 'time'"),
    "taken": (other(name="torque_gain"), "its name and law are taken: found torque_gain"),
    "family": (other(name="cogging"), "its name is taken, and it is no law of its own of that name: found cogging"),
    "starts raise": (other(starts=raising), "its starts raise an error: found ValueError: oops and more"),
    "starts of another": (starts(dubling=1.0), "its starts must give a value for each of doubling: found {'dubling'"),
    "starts are nan": (starts(doubling=math.nan), "its starts are not finite: found {'doubling': nan}"),
    "law raises": (other(torque=raising), "its law raises an error: found ValueError: oops and more"),
    "law of other arguments": (other(torque=lambda self, torque, p: torque), "its law raises an error: found TypeErr"),
    "law of numbers": (other(torque=lambda self, torque, *_: math.tanh(torque)), "its law gives values"),
    "law is nan": (other(torque=lambda self, torque, *_: ca.log(-1.0 - torque**2)), "its law gives values that are no"),
    "law of nothing": (other(torque=lambda *_: None), "its law raises an error: found "),
    "state without rate": (other(states=("z",)), "its law raises an error: found KeyError"),
    "states": (other(states="z"), "states must be a tuple of names: found 'z'"),
}
POINT = EntryPoint("mine", "my_package.drive:Drive", "stribeck.effects")


@pytest.mark.parametrize("name", FAULTS)
def test_a_fault_is_told(monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    kind, says = FAULTS[name]
    monkeypatch.setattr(EntryPoint, "load", lambda self: kind)
    with pytest.raises(InputError) as told:
        declared(POINT, {("torque_gain", ""), ("cogging", "wave")})
    where = "entry point 'mine' (my_package.drive:Drive) of a package, in the group stribeck.effects: "
    assert str(told.value).startswith(where + says)
    assert str(told.value).endswith("; correct a package, or uninstall it")


def test_what_is_declared_rightly_is_taken(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(EntryPoint, "load", lambda self: Good)
    assert type(declared(POINT, {("torque_gain", "")})) is Good


@every_effect
def test_none_of_the_librarys_is_refused(effect: Effect) -> None:
    check(effect)


@pytest.fixture
def installed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A folder, the current one and one of packages, that holds one whose effect cannot be imported."""
    facts = tmp_path / "mypack-0.1.dist-info"
    facts.mkdir()
    (facts / "METADATA").write_text("Metadata-Version: 2.1\nName: mypack\nVersion: 0.1\n")
    (facts / "entry_points.txt").write_text("[stribeck.effects]\nmine = mypack_drive:Drive\n")
    (tmp_path / "mypack_drive.py").write_text("import what_is_not_there\n")
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(str(tmp_path))
    laws.cache_clear()
    registry.cache_clear()
    yield tmp_path
    laws.cache_clear()
    registry.cache_clear()


def test_the_program_names_the_package(installed: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["diagnose", "--example", "--out", "out"]) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert said.startswith("stribeck: entry point 'mine' (mypack_drive:Drive) of the package mypack, in the group ")
    assert "cannot be imported: found ModuleNotFoundError: No module named 'what_is_not_there'" in said
    assert "correct the package mypack, or uninstall it" in said
    assert not (installed / "out").exists()


WAVES = {"1/rad": True, "1/m": True, "Hz": True, "1/s": False, "1": False, "rad": False}


@pytest.mark.parametrize(("unit", "wave"), WAVES.items())
def test_a_rate_is_no_wave(unit: str, *, wave: bool) -> None:
    """What is held while the arm's values are re-tuned is how often a wave repeats, not every reciprocal."""
    assert Parameter("number", unit, "a number").pitch is wave
