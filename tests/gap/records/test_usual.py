"""A velocity that all drives of an arm smooth alike, and shortly, is their habit; of one among others it is a cause."""

from dataclasses import replace

import numpy as np

from stribeck.arm import EffectEntry
from stribeck.gap.records.observed import Observation, observe
from stribeck.gap.records.prepare import prepare
from stribeck.run import Run

from ..conftest import NOMINAL, recorded

TWO = replace(NOMINAL, joints=(NOMINAL.joints[0], replace(NOMINAL.joints[0], name="B")))


def filtered(time: float) -> tuple[Run, ...]:
    return recorded(("velocity_filter", {"time": time}), channels=("dq",))


BOTH = filtered(0.015)  # at 250 Hz


def beside(first: tuple[Run, ...], second: tuple[Run, ...]) -> tuple[Run, ...]:
    """Recordings of two joints that do the same."""
    return tuple(
        replace(a, **{name: np.hstack([getattr(a, name), getattr(b, name)]) for name in ("q", "dq", "tau")})
        for a, b in zip(first, second, strict=True)
    )


def seen(*joints: tuple[Run, ...]) -> Observation:
    arm, runs = (NOMINAL, joints[0]) if len(joints) == 1 else (TWO, beside(*joints))
    return observe(arm, runs, prepare(arm, runs).scales)


def test_a_short_filter_of_all_joints_is_told_and_not_named() -> None:
    for found in (seen(filtered(0.006)), seen(filtered(0.006), filtered(0.006))):
        assert not found.causes
        assert not found.placed
        assert all("no more than any joint has" in note for note in found.notes)
        assert found.notes


def test_what_smooths_over_two_samples_is_short_however_long_they_are() -> None:
    every = tuple(replace(run, **{name: getattr(run, name)[::3] for name in ("t", "q", "dq", "tau")}) for run in BOTH)
    assert all(run.sample_time > 0.01 for run in every)
    assert not seen(every).causes
    assert seen(every).notes
    assert [cause.effect for cause in seen(BOTH).causes] == ["velocity_filter"]


def test_a_long_one_is_a_cause() -> None:
    (cause,) = seen(filtered(0.02)).causes
    assert cause.effect == "velocity_filter"


def test_so_is_a_short_one_of_one_joint_among_others() -> None:
    found = seen(filtered(0.006), filtered(0.0))
    assert [cause.joints for cause in found.causes] == [("A",)]
    assert not found.notes


def test_what_the_arm_file_states_is_neither_told_nor_named() -> None:
    stated = EffectEntry("velocity_filter", ("A",), {"A": {"time": 0.006}})
    arm, runs = replace(NOMINAL, effects=(stated,)), filtered(0.006)
    assert observe(arm, runs, prepare(NOMINAL, runs).scales) == Observation((), ())


def test_a_counter_that_begins_anew_trails_nothing() -> None:
    plain = recorded(channels=("dq",))
    assert not seen(plain).causes
    around = tuple(replace(run, q=(run.q - run.q.mean()) % (2.0 * np.pi)) for run in plain)
    assert any(np.ptp(run.q) > 6.0 for run in around)
    assert not seen(around).causes


def test_one_that_the_arm_file_has_otherwise_is_told_of() -> None:
    """Named it is not, for the file has it; an entry without values is as if it were not there."""
    runs = filtered(0.02)
    for stated, named, told in (({"time": 0.006}, 0, 1), ({"time": 0.02}, 0, 0), ({}, 1, 0)):
        arm = replace(NOMINAL, effects=(EffectEntry("velocity_filter", ("A",), {"A": stated}),))
        found = observe(arm, runs, prepare(arm, runs).scales)
        assert len(found.causes) == named
        assert len([note for note in found.notes if "by the records, 0.006 in the arm file" in note]) == told
        assert len(found.notes) == told
