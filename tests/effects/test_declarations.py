"""What every effect declares: name and place, units, bounds, starts, and words for the reader."""

import ast
import inspect
import math
import re
from dataclasses import replace
from importlib.metadata import EntryPoint, EntryPoints
from pathlib import Path
from typing import get_args

import casadi as ca
import numpy as np
import pytest

from stribeck.arm import Arm, EffectEntry, Friction, Joint, load_arm, save_arm
from stribeck.effects import registry as module
from stribeck.effects.declared import CHANNELS, STAGES
from stribeck.effects.placing import entries_of, placed_effects
from stribeck.effects.registry import effect_named, laws, registry
from stribeck.errors import InputError
from stribeck.model.effect import ActuatorEffect, Effect, Shows, StandEffect, TransmissionEffect
from stribeck.model.forward import Forward
from stribeck.model.layout import Placed, layout, values_of
from stribeck.model.path import SignalPath
from stribeck.model.scale import Scale
from stribeck.model.values import Parameter

from .bench import every_effect, nominal_arm, starts, trace

UNIT = re.compile(r"(1|N m|N|W|m|rad|s|kg|Hz|kg m\^2)( s(\^2)?| m)?(/(1|W|rad|s|kg|m)(\^[0-9.]+)?)?")

OVAL = {"sine": 0.01, "cosine": 0.0, "second_sine": 0.0, "second_cosine": 0.005, "harmonic": 1.0}
SMALL = Scale(
    torque=0.1, friction=0.01, speed=0.5, travel=0.3, inertia=1e-3, sample_time=1e-3, length=0.1, distance=40.0
)
LARGE = Scale(torque=90.0, friction=12.0, speed=3.0, travel=4.0, inertia=6.0, sample_time=1e-2, length=0.8)
TINY = Scale(
    torque=2e-3, friction=2e-4, speed=20.0, travel=6.0, inertia=1e-7, sample_time=1e-3, length=0.02, distance=4e3
)
HUGE = Scale(torque=2e3, friction=300.0, speed=0.2, travel=2.0, inertia=500.0, sample_time=1e-2, length=2.0)
ODD = Scale(torque=1e-9, friction=0.0, speed=1e-6, travel=1e-6, inertia=1e-6, sample_time=1e-3, length=0.0)


@every_effect
def test_words(effect: Effect) -> None:
    assert re.fullmatch(r"[a-z]+(_[a-z]+)*", effect.name)
    assert re.fullmatch(r"([a-z]+(_[a-z]+)*)?", effect.law)
    assert effect.channel in CHANNELS
    for text in (effect.equation, effect.symptom, effect.source, inspect.getdoc(type(effect))):
        assert text
        assert text.strip() == text
        assert len(text) > 5
    assert effect.equation.count("{") == effect.equation.count("}")
    assert effect.shows in get_args(Shows)
    assert effect.shows.startswith("recorded ") == effect.direct


@every_effect
def test_parameters(effect: Effect) -> None:
    names = [parameter.name for parameter in effect.parameters]
    assert names
    assert len(set(names)) == len(names)
    for parameter in effect.parameters:
        assert re.fullmatch(r"[a-z]+(_[a-z]+)*", parameter.name)
        assert UNIT.fullmatch(parameter.unit), parameter.unit
        assert parameter.description
        assert parameter.lower < parameter.upper
        assert parameter.null <= parameter.upper or math.isinf(parameter.null)
        assert parameter.lower > 0.0 or not parameter.log
    assert effect.delays in (None, "command", "position")
    assert effect.delays is None or "time" in names


@every_effect
def test_what_depends_on_time_itself_says_how_fast(effect: Effect) -> None:
    """Steps of a simulation are bounded by it: what time does to a joint that sticks shows in no error."""
    if effect.direct or effect.delays:
        return
    arm = nominal_arm()
    forward = Forward(SignalPath(arm, [Placed(effect, effect.sites(arm.n)[0], dict(effect.starts(SMALL)[0]))]))
    depends = ca.depends_on(ca.vertcat(forward.rates, forward.margins), forward.time)
    assert depends == (effect.waves > 0)
    assert [multiple for _, multiple in forward.waves] == [effect.waves] * depends


@pytest.mark.parametrize("scale", [SMALL, LARGE, TINY, HUGE, ODD], ids=["small", "large", "tiny", "huge", "odd"])
@every_effect
def test_starts(effect: Effect, scale: Scale) -> None:
    """Trial values: complete, finite, within the bounds, and clear of the null."""
    trials = effect.starts(scale)
    assert trials
    for trial in trials:
        assert set(trial) == {parameter.name for parameter in effect.parameters}
        assert any(trial[parameter.name] != parameter.null for parameter in effect.parameters)
        for parameter in effect.parameters:
            assert math.isfinite(trial[parameter.name])
            if scale is not ODD:
                assert parameter.lower <= trial[parameter.name] <= parameter.upper


@pytest.mark.parametrize("law", ["break_away", "ageing", "at_rest", "frozen"])
def test_a_rise_that_is_never_reached_may_be_any(law: str) -> None:
    """Where rests are short against its time, the two grow together: what a second makes of them tells."""
    effect, other = effect_named("dwell_time", law), {"distance": 1e-3}
    assert effect.plausible({"rise": 3.0, "time": 20.0, **other}, SMALL)
    assert not effect.plausible({"rise": 6.0, "time": 20.0, **other}, SMALL)
    assert not effect.plausible({"rise": 0.3, "time": 0.1, **other}, SMALL)


@pytest.mark.parametrize(
    ("label", "values"),
    [
        ("negative_damping/exponential", {"amount": 0.3, "velocity": 5e-4}),
        ("negative_damping/gaussian", {"amount": 0.3, "velocity": 5e-4}),
        ("history/running_in", {"change": 0.3, "distance": 0.05, "kept": 1.0}),
    ],
)
def test_a_slow_axis_in_m_has_values_of_its_own(label: str, values: dict[str, float]) -> None:
    """An axis at 5 mm/s: within the bounds, and meant."""
    effect = laws()[tuple(label.split("/"))]  # type: ignore[index]
    axis = replace(HUGE, torque=1.0, friction=0.5, speed=5e-3, travel=0.05, distance=0.5, prismatic=True)
    assert all(parameter.lower <= values[parameter.name] <= parameter.upper for parameter in effect.parameters)
    assert effect.plausible(values, axis)


@every_effect
def test_starts_know_no_zero_of_the_encoder(effect: Effect) -> None:
    """Places are sought where the joint moves; all else is the same wherever that is."""
    moved = 40.0 * math.pi
    for one, other in zip(effect.starts(LARGE), effect.starts(replace(LARGE, middle=moved)), strict=True):
        for parameter in effect.parameters:
            assert other[parameter.name] == pytest.approx(one[parameter.name] + moved * parameter.place)


@pytest.mark.parametrize("scale", [SMALL, LARGE, TINY, HUGE], ids=["small", "large", "tiny", "huge"])
@every_effect
def test_starts_are_plausible(effect: Effect, scale: Scale) -> None:
    assert all(effect.plausible(start, scale) for start in effect.starts(scale))


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("torque_saturation", {"limit": 0.02}),  # a drive that hardly drives: seen on a real joint without one
        ("torque_dead_zone", {"width": 0.2}),
        ("encoder_eccentricity", {"sine": 0.12, "cosine": -0.12, "harmonic": 1.0}),  # it would be inertia that is meant
        ("encoder_eccentricity", {"sine": 0.05, "cosine": 0.0, "harmonic": 30.0}),  # steeper than the angle itself
        ("encoder_eccentricity", {"sine": 0.005, "cosine": 0.0, "harmonic": 15.0}),  # two thirds of a period
        ("encoder_eccentricity", {"sine": 0.01, "cosine": 0.0, "harmonic": 2.5}),  # what no disc has, hardly seen
        ("encoder_eccentricity", {"sine": 0.01, "cosine": 0.0, "harmonic": 13.0}),  # more lobes than a disc has screws
        ("encoder_eccentricity/two_waves", OVAL | {"sine": 0.2}),
        ("encoder_eccentricity/two_waves", OVAL | {"second_cosine": 0.2}),  # beyond nine degrees, the second wave too
        ("backlash", {"gap": 1e-5, "stiffness": 200.0, "damping": 0.1}),  # a fiftieth of the wind-up under 0.1 N m
        ("backlash", {"gap": 1.9e-4, "stiffness": 1e4, "damping": 0.1}),  # any contact gives so much before it slides
        ("joint_flexibility", {"stiffness": 40.0, "damping": 0.3}),  # half as much again as would let it ring
        ("negative_damping", {"amount": 47.0, "velocity": 0.002}),  # the same at rest
        ("dwell_time", {"rise": 0.7, "time": 1.3, "distance": 3e-4}),  # a fall as 1 / v, by a rise beyond all torque
        ("dwell_time/at_rest", {"rise": 0.7, "time": 1.3, "distance": 3e-4}),
        ("dwell_time/frozen", {"rise": 0.7, "time": 1.3}),
        ("contact", {"stiffness": 1.0, "position": 0.1, "damping": 2.0 / SMALL.speed}),  # at usual speed a damper
        ("contact/linear", {"stiffness": 1.0, "position": 0.1, "damping": 0.4 * SMALL.travel / SMALL.speed}),
        ("cogging", {"sine": 0.02, "cosine": 0.0, "harmonic": 15.3}),  # two thirds of a period: any curve over position
        ("torque_ripple", {"sine": 0.1, "cosine": 0.0, "harmonic": 15.3}),
        (
            "history/running_in",
            {"change": 3.0, "distance": 90.0, "kept": 1.0},
        ),  # over all recordings, friction of another level
        ("history/in_time", {"change": 0.3, "time": 300.0, "kept": 1.0}),  # the same in time
    ],
)
def test_corners_are_not(name: str, values: dict[str, float]) -> None:
    assert not effect_named(*name.split("/")).plausible(values, SMALL)


WHOLE = [(3.0, 1.2, True), (3.0, 0.9, False), (3.3, 1.2, False)]


@pytest.mark.parametrize(("harmonic", "travel", "told"), WHOLE)
@pytest.mark.parametrize("name", ["encoder_eccentricity", "cogging", "torque_ripple"])
def test_screws_slots_and_magnets_come_in_whole_numbers(name: str, harmonic: float, travel: float, told: bool) -> None:
    """Half a period shows it; between two whole numbers it may be any curve over position."""
    values = {"sine": 0.013, "cosine": 0.02, "harmonic": harmonic}
    here = replace(SMALL, travel=travel, covered=travel)
    assert effect_named(name).plausible(values, here) == told
    assert not effect_named(name).plausible(values, replace(here, prismatic=True))  # nothing goes round there


@pytest.mark.parametrize("name", ["cogging", "torque_ripple"])
def test_one_or_two_cycles_a_turn_are_gravitys(name: str) -> None:
    values = {"sine": 0.013, "cosine": 0.02, "harmonic": 2.0}
    assert not effect_named(name).plausible(values, replace(SMALL, travel=2.0, covered=2.0))


@pytest.mark.parametrize("law", ["constant", "back_emf", "smooth"])
def test_a_drive_may_be_at_its_limit_most_of_the_time(law: str) -> None:
    """Its controller then asks for ever more: the command is no measure of what the motion needs."""
    values = {"limit": 0.5 * SMALL.torque, "fade": 0.0}
    assert effect_named("torque_saturation", law).plausible(values, SMALL)
    wound_up = replace(SMALL, torque=8.0 * SMALL.torque, needed=SMALL.torque)
    assert effect_named("torque_saturation", law).plausible(values, wound_up)
    assert not effect_named("torque_saturation", law).plausible({"limit": 0.02, "fade": 0.0}, wound_up)


@pytest.mark.parametrize("name", ["cogging", "torque_ripple", "cogging/two_waves", "torque_ripple/two_waves"])
def test_a_wave_may_be_covered_by_several_runs_together(name: str) -> None:
    effect = effect_named(*name.split("/"))
    values = {p.name: 0.01 for p in effect.parameters} | {"harmonic": 12.3}  # 0.59 of a period in the longest run
    assert not effect.plausible(values, SMALL)
    assert not effect.plausible(values, replace(SMALL, covered=0.5))  # 0.98 of one: an offset and a curve
    assert effect.plausible(values, replace(SMALL, covered=0.55))


def test_a_shaft_is_sought_from_soft_to_stiff() -> None:
    """Beside the little that a stiff one leaves, a start from a soft one is hopeless; no step is over an octave."""
    starts = effect_named("joint_flexibility").starts(SMALL)
    hertz = np.sqrt([start["stiffness"] / SMALL.link for start in starts]) / (2.0 * np.pi)
    assert hertz[0] < 5.0
    assert hertz[-1] > 60.0
    assert np.all(np.diff(np.log2(hertz)) < 1.01)


@every_effect
def test_starts_in_sight_of_the_residual(effect: Effect) -> None:
    for joint in effect.sites(2):
        for trial in starts(effect, joint):
            for parameter in effect.parameters:
                assert parameter.lower <= trial[parameter.name] <= parameter.upper, parameter.name


def test_a_wall_is_sought_with_a_damping_that_can_be_meant_however_fast_the_joint() -> None:
    wall, fast = effect_named("contact"), replace(LARGE, speed=20.0)
    assert all(wall.plausible(trial, fast) for trial in wall.starts_from(fast, trace(0)))


@every_effect
def test_stage_and_sites(effect: Effect) -> None:
    assert sum(isinstance(effect, stage) for stage in STAGES) == 1
    for n in range(1, 5):
        sites = effect.sites(n)
        assert sites
        assert set(sites) <= set(range(n))
        assert len(sites) == 1 or not effect.whole_arm


@every_effect
def test_file(effect: Effect) -> None:
    """One final class in effects/<channel>/<name>.py, or <name>_<law>.py for a further law of a family.

    It knows no other effect and nothing downstream.
    """
    kind = type(effect)
    if not kind.__module__.startswith("stribeck.effects."):
        return  # from another package
    path = Path(inspect.getfile(kind))
    first = effect_named(effect.name) is effect
    assert path.stem == (effect.name if first else f"{effect.name}_{effect.law}")
    assert path.parent.name == effect.channel
    assert kind.__name__ == path.stem.title().replace("_", "")
    assert kind.__final__
    tree = ast.parse(path.read_text(encoding="utf-8"))
    imported = [node.module or "" for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)]
    imported += [name.name for node in ast.walk(tree) if isinstance(node, ast.Import) for name in node.names]
    assert all(
        name.startswith(("stribeck.model.", "stribeck.quantum")) for name in imported if name.startswith("stribeck")
    )


@every_effect
def test_registered_once(effect: Effect) -> None:
    assert effect_named(effect.name, effect.law) is effect
    assert [e.label for e in laws().values()].count(effect.label) == 1


def test_laws_of_a_family() -> None:
    """They share the channel, and the stage unless they take the arm's whole stand; all have a law's name.

    The first is meant where none is given.
    """
    for name, first in registry().items():
        family = [effect for effect in laws().values() if effect.name == name]
        assert family[0] is first
        assert len({(e.channel, e.whole_arm) for e in family}) == 1
        stages = {next(kind for kind in type(e).__mro__ if Effect in kind.__bases__) for e in family}
        assert len(stages) == 1 or stages == {TransmissionEffect, StandEffect}
        assert all(e.sites(3) == ((0,) if e.everywhere else first.sites(3)) for e in family)
        assert len(family) == 1 or all(effect.law for effect in family)
        assert len(family) > 1 or not first.law


def test_a_law_that_holds_at_all_joints_is_given_once() -> None:
    def placed(*joints: str) -> tuple[Placed, ...]:
        late = {joint: {"time": 0.01} for joint in joints}
        return placed_effects(replace(nominal_arm(), effects=(EffectEntry("time_shift", joints, late, "all_joints"),)))

    (place,) = placed("A")
    assert place.joints(2) == (0, 1)
    assert Placed(effect_named("time_shift"), 1).joints(2) == (1,)
    with pytest.raises(InputError, match="time_shift/all_joints holds at all joints and is given once: found B"):
        placed("A", "B")


def stated(*entries: EffectEntry, prismatic: bool = False) -> tuple[Placed, ...]:
    arm = nominal_arm()
    if prismatic:
        arm = replace(arm, joints=(replace(arm.joints[0], kind="prismatic"),))
    return placed_effects(replace(arm, effects=entries))


@pytest.mark.parametrize(
    ("entries", "prismatic", "says"),
    [
        ([("base_flexibility", ("B",), "sliding")], False, "is of the whole arm and given once: found B"),
        ([("base_flexibility", ("A", "B"), "rocking")], False, "is of the whole arm and given once: found B"),
        ([("base_flexibility", ("A",), "sliding")], True, "base_flexibility/sliding is no law for this kind of arm"),
        ([("contact", ("A",), "plane")], True, "contact/plane is no law for this kind of arm"),
        (
            [("base_flexibility", ("A",), "rocking"), ("base_flexibility", ("A",), "sliding")],
            False,
            "is given twice: found A",
        ),
        ([("contact", ("A",), "plane"), ("contact", ("B",), "linear")], False, "contact is given twice: found B"),
        ([("gravity_tilt", ("A", "B"), None)], False, "gravity_tilt is given twice: found B"),
        ([("presliding", ("B",), "lugre"), ("presliding", ("B",), "maxwell_slip")], False, "is given twice: found B"),
        (
            [("backlash", ("A",), None), ("joint_flexibility", ("A",), None)],
            False,
            r"effects\[1\].*one transmission only",
        ),
    ],
)
def test_what_cannot_stand_in_an_arm_file(
    entries: list[tuple[str, tuple[str, ...], str | None]], prismatic: bool, says: str
) -> None:
    with pytest.raises(InputError, match=says):
        stated(*(EffectEntry(name, joints, law=law) for name, joints, law in entries), prismatic=prismatic)


@pytest.mark.parametrize(
    ("effect", "values"),
    [("backlash", {"gap": 0.05}), ("joint_flexibility", {"damping": 1.0}), ("presliding", {"damping": 2.0})],
)
def test_a_law_without_what_makes_it_one_is_refused(effect: str, values: dict[str, float]) -> None:
    """A gap on a link of no stated stiffness was left out of simulations and exports without a word."""
    with pytest.raises(InputError, match=rf"effects\[0\]\.parameters\.A\.stiffness is missing.*no {effect}"):
        stated(EffectEntry(effect, ("A",), {"A": values}))


@pytest.mark.parametrize(
    ("law", "values", "folds"),
    [
        ("one_wave", {"sine": 0.24, "harmonic": 4.0}, True),
        ("one_wave", {"sine": 0.2, "harmonic": 4.0}, False),
        ("two_waves", {"sine": 0.2, "second_sine": -0.06, "harmonic": 4.0}, True),
        ("two_waves", {"sine": 0.2, "second_cosine": 0.06, "harmonic": 3.0}, False),
    ],
)
def test_a_sensor_that_reads_the_same_at_two_positions_is_refused(
    law: str, values: dict[str, float], folds: bool
) -> None:
    entry = EffectEntry("encoder_eccentricity", ("A",), {"A": values}, law)
    if not folds:
        assert stated(entry)
        return
    with pytest.raises(InputError, match=r"effects\[0\]\.parameters\.A: .*reads the same at two positions"):
        stated(entry)


def test_a_payload_may_hang_on_any_link() -> None:
    """And tilted gravity may be stated at any joint: neither is bound to where a search would put it."""
    for name in ("payload", "gravity_tilt"):
        for joint in ("A", "B"):
            assert [place.joint for place in stated(EffectEntry(name, (joint,)))] == ["AB".index(joint)]


def test_a_payload_on_a_straight_axis_is_tried_as_a_part_of_its_mass() -> None:
    """Whatever length the file states: it has no lever."""
    axis = Scale(1.0, 1.0, 1.0, 1.0, 2.0, 1e-3, length=0.0, prismatic=True)
    for length in (0.0, 0.5):
        assert registry()["payload"].starts(replace(axis, length=length)) == ({"mass": pytest.approx(0.2)},)


def test_two_laws_of_a_family_at_two_joints_may_stand() -> None:
    entries = (EffectEntry("contact", ("A",), law="linear"), EffectEntry("contact", ("B",), law="hunt_crossley"))
    assert [place.joint for place in stated(*entries)] == [0, 1]


def test_a_law_in_an_arm_file() -> None:
    arm = nominal_arm()

    def placed(law: str | None) -> str:
        return placed_effects(replace(arm, effects=(EffectEntry("presliding", ("A",), law=law),)))[0].effect.law

    assert placed(None) == placed("lugre") == "lugre"
    assert placed("maxwell_slip") == "maxwell_slip"
    with pytest.raises(InputError, match="law is not a law of presliding: found 'dahl'; use one of: lugre, max"):
        placed("dahl")
    with pytest.raises(InputError, match="law is not a law of delay: found 'pade'; leave law out"):
        effect_named("delay", "pade")


def test_every_file_is_registered() -> None:
    folder = Path(module.__file__).parent
    files = {path.stem for path in folder.glob("*/*.py")} - {"__init__"}
    kinds = [type(effect) for effect in laws().values()]
    own = [kind.__module__ for kind in kinds if kind.__module__.startswith("stribeck.effects.")]
    assert sorted(name.rpartition(".")[2] for name in own) == sorted(files)


@every_effect
def test_arm_file_round_trip(effect: Effect, tmp_path: Path) -> None:
    """What `diagnose` writes of an effect reads back as the same model."""
    arm = nominal_arm()
    joints = tuple(arm.names[j] for j in effect.sites(2))
    values = {name: starts(effect, j)[0] for name, j in zip(joints, effect.sites(2), strict=True)}
    corrected = replace(arm, effects=(EffectEntry(effect.name, joints, values, effect.law or None),))
    save_arm(corrected, tmp_path / "arm.toml")
    again = load_arm(tmp_path / "arm.toml")
    assert again == corrected
    placed = placed_effects(again)
    assert entries_of(again, placed) == corrected.effects
    assert values_of(layout(again, placed)) == pytest.approx(values_of(layout(corrected, placed_effects(corrected))))
    written = {entry.key: entry.value for entry in layout(again, placed)}
    for joint, parameters in values.items():
        for name, value in parameters.items():
            assert written[f"{effect.name}[{joint}].{name}"] == value


@every_effect
def test_wrong_entries_are_refused(effect: Effect) -> None:
    arm = nominal_arm()
    joint = arm.names[effect.sites(2)[0]]

    def place(**values: float) -> None:
        placed_effects(replace(arm, effects=(EffectEntry(effect.name, (joint,), {joint: values}, effect.law or None),)))

    place()  # what is not given is at its null
    with pytest.raises(InputError, match=rf"effects\[0\].parameters.{joint}.nonsense is not a known key; use one of: "):
        place(nonsense=1.0)
    for parameter in effect.parameters:
        for bound, way in ((parameter.lower, -1.0), (parameter.upper, 1.0)):
            beyond = bound + way * (1.0 + abs(bound))
            if math.isfinite(bound) and beyond != parameter.null:
                with pytest.raises(InputError, match=rf"{joint}.{parameter.name} is out of bounds: found "):
                    place(**{parameter.name: beyond})


def test_unknown_effect() -> None:
    with pytest.raises(InputError, match="effect is not a known effect: found 'gremlins'"):
        effect_named("gremlins")


def test_effects_of_other_packages(monkeypatch: pytest.MonkeyPatch) -> None:
    """An entry point adds an effect, or a law to a name; it cannot replace one of the library's, and says so."""
    points = [
        EntryPoint("brush", f"{__name__}:Brush", "stribeck.effects"),
        EntryPoint("pade", f"{__name__}:Pade", "stribeck.effects"),
    ]
    impostor = EntryPoint("delay", f"{__name__}:Impostor", "stribeck.effects")
    monkeypatch.setattr(module, "entry_points", lambda group: EntryPoints(points).select(group=group))
    monkeypatch.setattr(EntryPoint, "load", lambda self: globals()[self.attr])
    laws.cache_clear()
    registry.cache_clear()
    try:
        assert list(registry())[-1] == "brush"
        assert type(effect_named("delay", "pade")) is Pade
        assert effect_named("delay") is registry()["delay"]
        points.append(impostor)
        laws.cache_clear()
        with pytest.raises(InputError, match=r"^entry point 'delay' \(.*:Impostor\).* its name and law are taken"):
            laws()
    finally:
        laws.cache_clear()
        registry.cache_clear()


class Brush(ActuatorEffect):
    """Stands for an effect of another package."""

    name = "brush"
    channel = "actuator"
    equation = "u - b"
    symptom = "torque that is lost"
    source = "a test"
    parameters = (Parameter("lost", "N m", "torque that is lost"),)

    def starts(self, scale: Scale) -> tuple[dict[str, float], ...]:
        return ({"lost": 1.0},)


class Impostor(Brush):
    """Takes a name that is taken."""

    name = "delay"


class Pade(Impostor):
    """Adds a law to a name that is taken."""

    law = "pade"


@pytest.mark.parametrize("part", [0.0005, 0.002, 0.01, 0.05])
def test_a_start_is_near_any_bristle_and_any_play(part: float) -> None:
    """Of a twentieth of a per cent of the travel to some: what is further than thrice from all starts gets lost."""
    for law in ("lugre", "maxwell_slip", "elasto_plastic"):
        given = [values["stiffness"] for values in effect_named("presliding", law).starts(LARGE)]
        assert min(abs(math.log(k * part * LARGE.travel / LARGE.friction)) for k in given) < math.log(3.0)
    gaps = [values["gap"] for values in effect_named("backlash").starts(LARGE)]
    assert min(abs(math.log(gap / (part * LARGE.travel))) for gap in gaps) < math.log(2.0)


@pytest.mark.parametrize("name", ["joint_flexibility", "backlash"])
def test_a_rotor_does_not_stiffen_the_starts(name: str) -> None:
    """What rings behind a gearbox is the link; the reflected rotor may be ten times as heavy."""
    direct = replace(LARGE, inertia=0.5)
    geared = replace(direct, inertia=5.5, rotor=5.0)
    first, second = ([start["stiffness"] for start in registry()[name].starts(scale)] for scale in (direct, geared))
    assert second == pytest.approx(first)


@pytest.mark.parametrize(("C1", "C2", "which"), [(0.5, 0.3, "all"), (0.0, 0.3, "whole"), (0.0, 0.0, "none")])
def test_without_a_falling_part_it_is_the_viscous_one_that_trails(C1: float, C2: float, which: str) -> None:
    """Only in the laws of the whole curve: nothing else depends on the speed there."""
    friction = Friction(2.0, C1, C2, 0.05)
    joint = Joint("A", "revolute", 0.3, 2.0, (0.15, 0.0), 0.03, 0.05, friction, friction)
    arm = Arm("one", (0.0, 0.0), (joint,))
    trailing = {effect.law for effect in laws().values() if effect.name == "frictional_lag"}
    whole = {"delay", "whole_curve"}
    wanted = {"all": trailing, "whole": whole, "none": set()}[which]
    assert whole < trailing
    assert {law for law in trailing if effect_named("frictional_lag", law).applies(arm, 0)} == wanted
