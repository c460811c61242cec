"""What waves over position or a dither force on a loop: told from cycles of the loop's own by their period."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from stribeck.arm import Arm, EffectEntry, Friction, Joint
from stribeck.loop.analyse import analyse_loop
from stribeck.loop.ripple import Passage, forced_by, passages
from stribeck.loop.surroundings import Grid
from stribeck.simulate import Compensation, JointLoop, Loop, Reference

A = Friction(5.0, 1.25, 1.5, 0.05)
WAVE = EffectEntry("position_dependent_friction", ("A",), {"A": {"sine": 0.2, "cosine": 0.0, "harmonic": 3.0}})
PASSED = Passage("position_dependent_friction", "A", 2.0 * math.pi / (3.0 * 0.5))


def arm(**changed: object) -> Arm:
    joint = Joint("A", "revolute", 0.3, 1.0, (0.0, 0.0), 0.5, 0.5, A, A)
    return replace(Arm("one joint", (0.0, 0.0), (joint,), effects=(WAVE,)), **changed)  # type: ignore[arg-type]


def loop(reference: Reference) -> Loop:
    return Loop(0.0, 10.0, (JointLoop("A", 60.0, reference, kv=15.0),))


def test_a_ramp_passes_waves_and_turns_under_gravity() -> None:
    ramp = loop(Reference("ramp", velocity=-0.5))
    assert passages(arm(), ramp) == (PASSED,)
    assert passages(arm(effects=()), ramp) == ()
    assert passages(arm(), loop(Reference("regulate"))) == ()
    heavy = passages(arm(gravity=(0.0, -9.81)), ramp)
    assert heavy == (PASSED, Passage("gravity", "A", 4.0 * math.pi))


def test_a_dither_forces_whatever_keeps_its_time() -> None:
    law = Compensation("dither", amplitude=8.0, frequency=2.0)
    entry = JointLoop("A", 60.0, Reference("regulate"), kv=15.0, compensation=law)
    (shaken,) = passages(arm(), Loop(0.0, 10.0, (entry,)))
    assert shaken == Passage("dither", "A", 0.5)
    assert passages(arm(), Loop(0.0, 10.0, (replace(entry, compensation=replace(law, amplitude=0.0)),))) == ()
    for verdict in ("hunting", "stick_slip", "chatter", "sliding_cycle"):
        assert forced_by(verdict, 0.5, (shaken,)) == shaken
        assert forced_by(verdict, 1.5000001, (shaken,)) == shaken  # samples fall on it in turn
        assert forced_by(verdict, 0.7, (shaken,)) is None
        assert forced_by(verdict, 0.25, (shaken,)) is None
        assert forced_by(verdict, 50.0, (shaken,)) is None  # some number of its periods is near any long one
    assert forced_by("rest", None, (shaken,)) is None


@pytest.mark.parametrize(
    ("verdict", "period", "forced"),
    [
        ("sliding_cycle", PASSED.time * 1.001, True),
        ("sliding_cycle", PASSED.time * 1.1, False),
        ("stick_slip", PASSED.time, False),
        ("rest", None, False),
    ],
)
def test_what_never_sticks_and_keeps_the_waves_time_is_forced(
    verdict: str, period: float | None, *, forced: bool
) -> None:
    assert forced_by(verdict, period, (PASSED,)) == (PASSED if forced else None)


@pytest.mark.long
def test_an_analysis_says_what_forces_a_ripple() -> None:
    found = analyse_loop(arm(), loop(Reference("ramp", velocity=0.5)), grid=Grid(wanted=False)).joints[0]
    assert found.cycle.verdict == "sliding_cycle"
    assert found.forced == PASSED
    assert found.methods["shooting"].why.startswith("a forced ripple")
    assert any("a ripple that the arm forces, and no limit cycle" in note for note in found.notes)
    assert found.branch is not None
    assert all(forced_by(cycle.verdict, cycle.period, found.passes) for cycle in found.branch.cycles[-3:])
