"""Laws of no library that pass for an effect are told from it; the effect itself stands against all of them."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import casadi as ca
import numpy as np
import pytest
from joblib import Parallel
from scipy.integrate import solve_ivp
from scipy.interpolate import interp1d

from stribeck.arm import Arm
from stribeck.effects.registry import effect_named, registry
from stribeck.gap.answer.verdict import NAMED_OVER, causes_of
from stribeck.gap.diagnose import diagnose
from stribeck.gap.fitted.model import Model, fit_model, retune, weights_of
from stribeck.gap.records.prepare import Prepared, prepare
from stribeck.gap.search.decoys import DAMPING, MOVED, RINGS, WARMS, decoys
from stribeck.gap.search.look_alike import TELLING, _in_its_place, doubt, told_alike, with_look_alikes
from stribeck.gap.search.rank import rank
from stribeck.gap.search.step import LookAlike, Step
from stribeck.model.layout import Placed
from stribeck.model.rigid_body import inverse_dynamics
from stribeck.model.scale import Scale
from stribeck.model.values import Body
from stribeck.run import Run
from stribeck.withheld.arms import misinformed
from stribeck.withheld.excitation import programme
from stribeck.withheld.injections import Injection
from stribeck.withheld.recorder import default_gains, record

from ..conftest import JOINT, conditioned, recorded, taken_steps
from ..conftest import NOMINAL as PENDULUM

TRUE = Arm("two joints", (9.81, 0.0), (JOINT, replace(JOINT, name="B", mass=2.5)), sample_time=0.004)
NOMINAL = misinformed(TRUE, np.random.default_rng(3), 0.03, 0.2)
CROSS_TALK = 0.05
FLOOR = np.array([0.03, 0.03])
OTHERS = tuple(name for name in registry() if name not in ("torque_gain", "payload", "cable_spring"))


def recordings(*hidden: Injection) -> list[Run]:
    kinds = ("slow reversals", "multisine", "via points", "point to point")
    motions = programme(NOMINAL, np.random.default_rng(1), kinds, 4.0)
    gains = default_gains(NOMINAL, 3.0)
    return list(record(TRUE, hidden, motions, rate=250.0, noise=1e-5, gains=gains, model=NOMINAL, seed=5))


def crossed(runs: list[Run]) -> list[Run]:
    """The same motions under drives of which the second also gives a share of the first one's command."""
    mixing = np.array([[1.0, 0.0], [CROSS_TALK, 1.0]])
    return [replace(run, tau=run.tau @ np.linalg.inv(mixing).T) for run in runs]


@pytest.mark.slow
def test_cross_talk_of_drives_is_no_torque_gain() -> None:
    found = diagnose(NOMINAL, crossed(recordings()), leave_out=OTHERS, jobs=1)
    assert not found.named
    assert found.verdict == "unexplained"
    assert any("a share of A's command at B" in text for text in found.warnings)
    (unknown,) = (cause for cause in found.causes if cause.effect == "unknown")
    assert unknown.probability > 0.5


@pytest.mark.long
def test_a_torque_gain_is_no_cross_talk() -> None:
    found = diagnose(NOMINAL, recordings(Injection("torque_gain", "A", {"gain": 0.85})), leave_out=OTHERS, jobs=1)
    assert found.named == ("torque_gain",)
    assert found.causes[0].joints == ("A",)
    assert not any("library" in text for text in found.warnings)


def one_sided(runs: Sequence[Run], share: float) -> list[Run]:
    """The same motions under a drive that gives less of what is asked of it to one side."""
    return [replace(run, tau=np.where(run.tau < 0.0, run.tau / (1.0 - share), run.tau)) for run in runs]


@pytest.mark.long
@pytest.mark.parametrize("there", [True, False], ids=["half a bridge", "an offset"])
def test_a_drive_that_pulls_harder_to_one_side_is_no_offset(there: bool) -> None:
    others = tuple(name for name in registry() if name not in ("torque_offset", "asymmetric_friction"))
    runs = one_sided(recorded(), 0.2) if there else recorded(("torque_offset", {"offset": 0.6}))
    found = diagnose(PENDULUM, runs, leave_out=others, jobs=1)
    assert found.named == (() if there else ("torque_offset",))
    assert any("pulls harder to one side" in text for text in found.warnings) == there


def saturating(runs: Sequence[Run], most: float) -> list[Run]:
    """The same motions under a drive that gives c (1 - |c| / 4 m) of a command c, and no more than ``most``, m."""
    return [
        replace(run, tau=2.0 * most * np.sign(run.tau) * (1.0 - np.sqrt(1.0 - np.abs(run.tau) / most))) for run in runs
    ]


@pytest.mark.long
@pytest.mark.parametrize("there", [True, False], ids=["iron", "a gain"])
def test_a_drive_whose_gain_falls_with_its_torque_is_no_gain(there: bool) -> None:
    others = tuple(name for name in registry() if name not in ("torque_gain", "torque_dead_zone", "torque_saturation"))
    plain = recorded()
    most = 1.3 * max(float(np.abs(run.tau).max()) for run in plain)
    runs = saturating(plain, most) if there else recorded(("torque_gain", {"gain": 0.8}))
    found = diagnose(PENDULUM, runs, leave_out=others, jobs=1)
    assert found.named == (() if there else ("torque_gain",))
    assert any("iron that saturates" in text for text in found.warnings) == there


def alike(*chances: float | None) -> list[Step]:
    """The steps of a search that took effects, with a decoy that does better than each with some chance."""
    placed = [Placed(effect_named(name), 1) for name in ("torque_gain", "cable_spring")[: len(chances)]]
    steps = taken_steps(placed, [9.0] * len(placed), gap=np.ones(2), floor=np.ones(2))
    found = [None if chance is None else LookAlike("something else", chance) for chance in chances]
    return [replace(step, look_alike=decoy) for step, decoy in zip(steps, found, strict=True)]


def test_its_chance_is_taken_from_the_presence() -> None:
    scales = (Scale(1.0, 1.0, 1.0, 1.0, 1.0, 1e-3),) * 2
    sure, doubted, gone = (causes_of(alike(c), ("A", "B"), scales) for c in (None, 0.5, 1.0))
    whole = sure[0][0].presence or 0.0
    assert whole > NAMED_OVER
    assert doubted[0][0].presence == pytest.approx(0.5 * whole)
    assert gone[0][0].presence == 0.0
    assert gone[1] == pytest.approx(1.0)  # left over, for unknown
    assert [doubt(alike(c)) for c in (None, 0.5, 1.0)] == pytest.approx([0.0, 0.5 * whole, whole])


def test_it_is_told_of_once() -> None:
    assert told_alike(alike(None), ("A", "B")) == []
    assert told_alike(alike(0.5 * TELLING), ("A", "B")) == []
    (better,) = told_alike(alike(0.9), ("A", "B"))
    assert better == "torque_gain at B: something else explains it better, and is no effect of the library"
    (both,) = told_alike(alike(0.4, 0.4), ("A", "B"))
    assert both.startswith("torque_gain at B and cable_spring at B: something else may explain it as well")


def test_what_one_joint_alone_cannot_tell_apart_is_told() -> None:
    stand = taken_steps([Placed(effect_named("base_flexibility"), 0)], [9.0], gap=np.ones(1), floor=np.ones(1))
    (told,) = told_alike(stand, ("A",))
    assert told.startswith("base_flexibility at A: with no joint behind it, a mass that swings on the link")
    assert told_alike(stand, ("A", "B")) == []


def test_every_pair_and_joint_has_its_decoys() -> None:
    arms = [
        replace(TRUE, joints=joints) for joints in ((JOINT,), TRUE.joints, (*TRUE.joints, replace(JOINT, name="C")))
    ]
    one, two, three = (list(decoys(arm)) for arm in arms)
    assert 0 < len(one) < len(two) < len(three)
    assert len({decoy.says for decoy in three}) == len(three)


def test_an_axis_has_no_turns() -> None:
    axis = replace(TRUE, joints=(replace(JOINT, kind="prismatic"),))
    assert [decoy.says for decoy in decoys(axis)] == [
        "torque that speed takes at A (a drive's voltage limit)",
        "a drive at A that pulls harder to one side (half of its bridge)",
        "a drive at A whose gain changes with its torque (iron that saturates)",
        "torque that heat takes at A (a magnet that warms)",
    ]


def smooth() -> Any:
    """Two joints on sines, with exact velocities and accelerations."""
    t = np.linspace(0.0, 6.0, 60001)
    size, rate, phase = np.array([0.9, 0.6]), 2.0 * np.pi * np.array([0.5, 0.8]), np.array([0.2, 1.1])
    q, v, a = (size * rate**k * np.sin(np.outer(t, rate) + phase + 0.5 * np.pi * k) for k in range(3))
    return SimpleNamespace(time=t, position=q, velocity=v, acceleration=a, command=2.0 * a + np.cos(q))


def torques(motion: Any, says: str) -> list[np.ndarray]:
    (decoy,) = (decoy for decoy in decoys(TRUE) if decoy.says.startswith(says))
    return [term(motion) for term in decoy.terms]


ENERGIES: dict[str, Callable[[Any], np.ndarray]] = {
    "an inertia at B that varies 1 time a turn": lambda m: 0.5 * np.cos(m.position[:, 1]) * m.velocity[:, 1] ** 2,
    "an inertia at A that varies 2 times a turn": lambda m: 0.5 * np.cos(2 * m.position[:, 0]) * m.velocity[:, 0] ** 2,
    "an inertia between A and B": lambda m: np.prod(m.velocity, axis=1),
    "a spring between A and B (an open": lambda m: 0.5 * np.diff(m.position, axis=1)[:, 0] ** 2,
    "a spring between A and B (a crossed": lambda m: 0.5 * np.sum(m.position, axis=1) ** 2,
}


@pytest.mark.parametrize("says", ENERGIES)
def test_what_stores_energy_gives_it_back(says: str) -> None:
    """The power of its torques is the rate of an energy: the law of an inertia or a spring, and no other."""
    motion = smooth()
    power = np.sum(torques(motion, says)[0] * motion.velocity, axis=1)
    rate = np.gradient(ENERGIES[says](motion), motion.time)
    np.testing.assert_allclose(power[5:-5], rate[5:-5], rtol=0, atol=2e-3 * np.abs(rate).max())


@pytest.mark.parametrize(("kind", "side"), [("common", 1.0), ("relative", -1.0)])
def test_what_rubs_takes_energy_in_its_own_motion_alone(kind: str, side: float) -> None:
    motion = smooth()
    (torque,) = torques(motion, f"friction between A and B, in their {kind}")
    power = np.sum(torque * motion.velocity, axis=1)
    np.testing.assert_allclose(power, np.abs(motion.velocity[:, 0] + side * motion.velocity[:, 1]), rtol=0, atol=1e-12)


FORMULAS: dict[str, Callable[[Any], tuple[Any, Any]]] = {
    "torque that speed takes at B": lambda m: (0.0, m.command[:, 1] * m.velocity[:, 1] ** 2),
    "a drive at B whose gain changes": lambda m: (0.0, m.command[:, 1] * np.abs(m.command[:, 1])),
    "a share of A's command at B": lambda m: (0.0, -m.command[:, 0]),
    "friction at A under the load of B": lambda m: (np.sign(m.velocity[:, 0]) * np.abs(m.command[:, 1]), 0.0),
    "torque at B by the square of A's speed": lambda m: (0.0, m.velocity[:, 0] ** 2),
    "damping between A and B": lambda m: (m.velocity[:, 1], m.velocity[:, 0]),
}


@pytest.mark.parametrize("says", FORMULAS)
def test_the_others_are_their_formulas(says: str) -> None:
    motion = smooth()
    (torque,) = torques(motion, says)
    expected = np.zeros_like(torque)
    expected[:, 0], expected[:, 1] = FORMULAS[says](motion)
    np.testing.assert_allclose(torque, expected, rtol=1e-6, atol=1e-12)


@pytest.mark.parametrize("slower", [0.0, 1.0])
def test_heat_takes_torque_as_the_winding_warms(slower: float) -> None:
    """Under a steady command its temperature comes to that of the loss with one time constant, cold at first."""
    t = np.arange(0.0, 30.0, 0.002)
    run: Any = SimpleNamespace(position=np.zeros((len(t), 1)), command=np.full((len(t), 1), -3.0), sample_time=0.002)
    arm = replace(TRUE, joints=(JOINT,))
    (decoy,) = (decoy for decoy in decoys(arm) if decoy.says.startswith("torque that heat takes"))
    assert decoy.nearby is not None
    torque = decoy.nearby(np.array([slower])).terms[0](run)[:, 0]
    warm = 1.0 - np.exp(-t / (WARMS * np.exp(slower)))
    np.testing.assert_allclose(torque, -27.0 * warm, rtol=0, atol=0.02)
    assert decoy.resists


def test_a_spring_may_rest_anywhere() -> None:
    constants = torques(smooth(), "a spring between A and B (an open")[1:]
    assert [constant.mean(axis=0).tolist() for constant in constants] == [[1.0, 0.0], [0.0, 1.0]]


@pytest.mark.parametrize(("way", "kind"), [(1.0, "a crossed"), (-1.0, "an open")])
def test_a_spring_between_joints_pulls_at_both_by_what_it_is_stretched(way: float, kind: str) -> None:
    """The torques are the slopes of k (q_1 +- q_2 - rest)^2 / 2."""
    motion = smooth()
    stretched = motion.position[:, 0] + way * motion.position[:, 1] - 0.3
    pull = np.column_stack([stretched, way * stretched]).ravel()
    terms = np.column_stack([term.ravel() for term in torques(motion, f"a spring between A and B ({kind}")])
    left = pull - terms @ np.linalg.lstsq(terms, pull, rcond=None)[0]
    assert np.abs(left).max() < 1e-9 * np.abs(pull).max()


def test_a_tool_that_rings_is_a_mass_on_a_spring_across_the_last_link() -> None:
    """Against its own equation of motion, driven by a tip that is differentiated by numbers."""
    motion, arm = smooth(), TRUE
    motion.sample_time = float(motion.time[1])
    hertz = float(RINGS[8])
    omega = 2.0 * np.pi * hertz
    (decoy,) = (decoy for decoy in decoys(arm) if decoy.says.startswith("a tool") and f"{hertz:.2g} Hz" in decoy.says)

    def tip(position: np.ndarray) -> np.ndarray:
        angle = np.cumsum(position, axis=-1)
        return np.stack([np.cos(angle), np.sin(angle)], axis=-2) @ np.array([joint.length for joint in arm.joints])

    last = motion.position.sum(axis=1)
    across = np.stack([-np.sin(last), np.cos(last)], axis=1)
    step = motion.sample_time
    speed = np.gradient(tip(motion.position), step, axis=0)
    felt = np.sum(across * (np.gradient(speed, step, axis=0) - np.array(arm.gravity)), axis=1)
    felt[:2] = felt[2]  # one-sided differences

    def rate(t: float, x: np.ndarray) -> list[float]:
        return [x[1], -2.0 * DAMPING * omega * x[1] - omega**2 * x[0] - np.interp(t, motion.time, felt)]

    bent = solve_ivp(rate, (0.0, 6.0), [-felt[0] / omega**2, 0.0], t_eval=motion.time, max_step=2e-3, rtol=1e-8)
    beyond = np.gradient(bent.y[1], step)
    lever = np.stack(
        [
            np.sum(across * (tip(motion.position + move) - tip(motion.position)) / 1e-6, axis=1)
            for move in 1e-6 * np.eye(2)
        ],
        axis=1,
    )
    expected, torque = lever * beyond[:, None], decoy.terms[1](motion)
    np.testing.assert_allclose(torque[50:-50], expected[50:-50], rtol=0, atol=5e-3 * np.abs(expected).max())


@pytest.mark.parametrize("octaves", [-1e3, -30.0, 30.0, 1e3])
def test_however_far_its_frequency_is_sought_a_tool_swings(octaves: float) -> None:
    """No slower than a recording shows: its filter would have no rest to begin at."""
    motion = smooth()
    motion.sample_time = float(motion.time[1])
    first = next(decoy for decoy in decoys(TRUE) if decoy.form == "tool")
    assert first.nearby is not None
    (term,) = first.nearby(np.array([octaves, 0.0, 0.0])).terms
    with np.errstate(over="ignore"):
        assert np.isfinite(term(motion)).all()


@pytest.mark.long
def test_a_tool_that_swings_is_a_third_link_on_a_soft_hinge() -> None:
    """Against the chain of three joints, the last of which is a spring: to the first order in its small swing."""
    motion, arm = smooth(), replace(TRUE, gravity=(0.0, 0.0))
    for name in ("position", "velocity", "acceleration"):
        setattr(motion, name, 0.05 * getattr(motion, name))
    motion.sample_time = float(motion.time[1])
    reach, hertz, damping = 0.3, 1.6, 0.04
    length, omega = reach * arm.joints[-1].length, 2.0 * np.pi * hertz
    body = Body(
        mass=(1e-9, 1e-9, 1.0), com_x=(0.0, 0.0, length), com_y=(0.0,) * 3, inertia=(0.0,) * 3,
        length=(*(joint.length for joint in arm.joints), length), gravity=arm.gravity,
    )  # fmt: skip
    q, v, a = (ca.SX.sym(name, 3) for name in "qva")
    needed = ca.vertcat(*inverse_dynamics(body, *(ca.vertsplit(values) for values in (q, v, a))))
    torques_of = ca.Function("needed", [q, v, a], [needed])
    known = interp1d(motion.time, np.hstack([motion.position, motion.velocity, motion.acceleration]), axis=0)

    def asked(t: Any, x: np.ndarray) -> np.ndarray:
        """All joints' torques, the hinge's own acceleration apart."""
        told = known(t).reshape(-1, 3, 2)
        states = [np.vstack([told[:, k].T, np.broadcast_to(x[k], len(told))]) for k in range(2)]
        return torques_of(*states, np.vstack([told[:, 2].T, np.zeros(len(told))])).full()

    def rate(t: float, x: np.ndarray) -> list[float]:
        pull = float(asked(t, x)[2, 0]) / length**2
        return [x[1], -(omega**2) * x[0] - 2.0 * damping * omega * x[1] - pull]

    start = -float(asked(0.0, np.zeros(2))[2, 0]) / (length * omega) ** 2
    few = motion.time[::20]
    swung = solve_ivp(rate, (0.0, 6.0), [start, 0.0], t_eval=few, max_step=5e-3, rtol=1e-8)
    beyond = np.gradient(swung.y[1], few)
    fixed = asked(few, np.zeros(2))
    told = known(few).reshape(-1, 3, 2)
    loose = [np.vstack([told[:, k].T, part]) for k, part in enumerate((swung.y[0], swung.y[1], beyond))]
    expected = (torques_of(*loose).full() - fixed)[:2].T
    moved = np.array([np.log(hertz / RINGS[0]), np.log(damping / DAMPING), reach]) / MOVED
    first = next(decoy for decoy in decoys(arm) if decoy.form == "tool")
    assert first.nearby is not None
    decoy = first.nearby(moved)
    assert f"{hertz:.2g} Hz" in decoy.says
    torque = decoy.terms[0](motion)[::20]
    assert np.abs(swung.y[0]).max() < 0.2
    assert torque[50:-50] == pytest.approx(expected[50:-50], abs=0.02 * np.abs(expected).max())


def test_rows_are_filtered_as_a_residual_is_and_rest_where_the_joint_does() -> None:
    run, other = conditioned([3.0, 4.0])
    run = replace(run, stuck=np.where(run.time[:, None] > 2.0, 1.0, 0.0))
    arm = replace(TRUE, joints=(JOINT,))
    for decoy in decoys(arm):
        rows = decoy.rows([run, other])
        assert rows.shape == (sum(len(one.analysis_index) for one in (run, other)), 1, len(decoy.terms))
        here = rows[: len(run.analysis_index), :, 0]
        time, reach = run.time[run.analysis_index], len(run.taps) * run.sample_time
        moving = replace(run, stuck=np.zeros_like(run.stuck))
        assert here[time < 2.0 - reach] == pytest.approx(run.filtered(decoy.terms[0](moving))[time < 2.0 - reach])
        assert np.any(here)
        assert not np.any(here[time > 2.0 + reach])


@pytest.fixture(scope="module")
def crossing() -> tuple[Prepared, Model]:
    """Recordings with cross-talk, and what re-tuning leaves of it."""
    prepared = prepare(NOMINAL, crossed(recordings()))
    return prepared, retune(prepared, FLOOR)


def test_a_decoy_takes_what_is_its_own_on_held_out_runs_too(crossing: tuple[Prepared, Model]) -> None:
    prepared, base = crossing
    weights = weights_of(base, prepared, FLOOR)
    (talk,) = (decoy for decoy in decoys(NOMINAL) if decoy.says.startswith("a share of A's command at B"))
    (idler,) = (decoy for decoy in decoys(NOMINAL) if "idler" in decoy.says)
    model = _in_its_place(prepared, base, talk, weights)
    assert model is not None
    assert model.absorbed == 1
    assert model.rms()[1] < 0.4 * base.rms()[1]
    pulling = replace(idler, terms=(lambda run: -idler.terms[0](run),))
    both = [_in_its_place(prepared, base, decoy, weights) for decoy in (idler, pulling)]
    assert sum(model is None for model in both) == 1  # one of the two would have to push
    bristle = Placed(effect_named("presliding"), 0, {"stiffness": 500.0, "damping": 1.0})
    beside = _in_its_place(prepared, fit_model(prepared, (bristle,), weights, base.fit, evaluations=2), talk, weights)
    assert beside is not None
    assert beside.rows is not None  # as of the model in whose place it stands


def test_one_decoy_for_several_effects(crossing: tuple[Prepared, Model]) -> None:
    """Two effects that were taken for cross-talk are both in doubt, even if neither alone can be replaced by it."""
    prepared, base = crossing
    weights = weights_of(base, prepared, FLOOR)
    placed = [Placed(effect_named(name), 1, {}) for name in ("torque_gain", "cable_spring")]
    first = fit_model(prepared, placed[:1], weights, base.fit, {"gain": 1.1})
    last = fit_model(prepared, (*first.placed, placed[1]), weights, first.fit, {"stiffness": 0.1, "rest": 0.0})
    steps = [
        Step(before, (after,), rank(prepared, [before, after], FLOOR, 0), (1,), (), FLOOR)
        for before, after in ((base, first), (first, last))
    ]
    with Parallel(n_jobs=1) as pool:
        out = with_look_alikes(prepared, steps, [last, last], pool, 0)  # nothing can be gained in the place of either
    assert all(step.look_alike is not None and step.look_alike.chance > 0.9 for step in out)
    assert {step.look_alike.says[:28] for step in out if step.look_alike} == {"a share of A's command at B "}
