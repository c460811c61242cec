"""Recordings in which nothing moves are refused; a joint of them that is driven in vain is told of."""

from dataclasses import replace

import numpy as np
import pytest

from stribeck.arm import Arm
from stribeck.errors import InputError
from stribeck.gap.diagnose import diagnose
from stribeck.gap.records.prepare import prepare
from stribeck.gap.records.standing import check_motion
from stribeck.run import Run

from ..conftest import JOINT, TRUE, sines

STEP = 2e-5
TWO = Arm("two joints", (0.0, 0.0), (JOINT, replace(JOINT, name="B")), sample_time=0.005)


def stood(seed: int, torque: float = 0.0, step: float = STEP) -> Run:
    """A joint whose encoder flickers between neighbouring steps, under a sine of torque."""
    t = np.arange(1000) * 0.005
    q = 0.3 + 0.01 * seed + step * np.random.default_rng(seed).choice([-1.0, 0.0, 1.0], len(t), p=[0.05, 0.9, 0.05])
    return Run(f"stood {seed}", t, q[:, None], torque * np.sin(3.0 * t)[:, None])


def beside(run: Run, other: Run) -> Run:
    q, tau = (np.hstack([getattr(one, name)[:1000] for one in (run, other)]) for name in ("q", "tau"))
    return Run(run.name, run.t[:1000], q, tau)


@pytest.mark.parametrize("torque", [0.0, 2.0])
@pytest.mark.parametrize("step", [0.0, STEP])
def test_recordings_in_which_nothing_moves_are_refused(torque: float, step: float) -> None:
    """A residual of nothing would pass for that of a perfect model; held-out runs are recordings as well."""
    still = [stood(k, torque, step) for k in range(3)]
    with pytest.raises(InputError, match=r"no joint moves .* nothing can be said .* at A, .*; record a motion"):
        diagnose(TRUE, still[:2], still[2:], jobs=1)
    with pytest.raises(InputError, match="no joint moves"):
        diagnose(TRUE, still[:1], jobs=1)
    moves = prepare(TRUE, still[:2], [sines(5.0)])
    check_motion(TRUE, (*moves.fit, *moves.held))


def test_a_motion_of_a_few_steps_is_one() -> None:
    """What a joint does before it slides can be told of friction."""
    run = stood(0, 2.0)
    moves = prepare(TRUE, [replace(run, q=run.q + 5.0 * STEP * run.tau)])
    check_motion(TRUE, (*moves.fit, *moves.held))


@pytest.mark.parametrize("step", [0.0, STEP])
def test_a_joint_that_moves_in_held_out_runs_alone_keeps_its_constants(step: float) -> None:
    """At rest any friction will do: what the file says, or has as zero, is all that is known of it."""
    rests = [beside(sines(5.0, seed=k, name=f"{k}"), stood(k, 2.0, step)) for k in range(2)]
    moves = beside(sines(5.0, seed=3, name="3"), sines(5.0, seed=4, name="4"))
    for constants in (JOINT.friction, replace(JOINT.friction, C0=0.0, C2=0.0)):
        joint = replace(TWO.joints[1], friction=constants, backward=constants)
        prepared = prepare(replace(TWO, joints=(TWO.joints[0], joint)), rests, [moves])
        assert {"C0", "C2"}.isdisjoint(prepared.arm.joints[1].tolerance)
        (text,) = [text for text in prepared.warnings if "alone" in text]
        assert text.startswith("B: it moves in held-out runs alone: nothing of it can be learnt")
    (text,) = [text for text in prepare(TWO, [moves], rests).warnings if "judges" in text]
    assert text.startswith("B: it moves in no run that is held out")


def test_a_joint_that_is_driven_in_vain_is_told_of() -> None:
    def told(torque: float, moved: float = 0.0) -> list[str]:
        runs = [beside(sines(5.0, seed=k, name=f"{k}"), stood(k, torque)) for k in range(2)]
        runs += [beside(sines(5.0, seed=2, name="2"), stood(2, torque))]
        runs[1].q[:, 1] += moved * np.sin(runs[1].t)
        return [text for text in prepare(TWO, runs).warnings if "moves in no recording" in text]

    (text,) = told(2.0)
    assert text.startswith("B: it is driven, but moves in no recording")
    assert told(0.0) == []  # held, as a note says
    assert told(2.0, moved=0.1) == []
