"""The maximum a posteriori fit: it finds what made the data, stays within its bounds, and says how it ended."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from stribeck.arm import Arm, Friction, Joint, Tolerance
from stribeck.effects.registry import registry
from stribeck.identify import map_fit
from stribeck.identify.conditioning import Conditioned, condition
from stribeck.identify.confidence import intervals
from stribeck.identify.map_fit import BOLD, CAREFUL, Fit, fit
from stribeck.identify.problem import LEVEL_LIMIT, PRIOR_LIMIT, Problem, Weights
from stribeck.identify.residual import Residual
from stribeck.model.layout import Entry, Placed, values_of
from stribeck.model.path import SignalPath

from .conftest import PENDULUM, pendulum, recorded, stronger

SURE = Weights(np.array([1e-4]), np.ones(1))


def made_by(path: SignalPath, p: np.ndarray, run: Conditioned) -> Conditioned:
    """The run with the command that the model itself, at p, asks for: nothing is left at p but rounding."""
    stages = Residual(path, [run], ()).stages(run, p)
    return replace(run, command=run.command - stages["residual"])


def clean(path: SignalPath, p: np.ndarray) -> Conditioned:
    return made_by(path, p, condition(pendulum(), recorded(rate=250.0), 20.0, np.full(1, 1.6e-11)))


def perturbed(path: SignalPath, size: float = 0.15) -> np.ndarray:
    p = values_of(path.entries)
    return np.asarray(p * (1.0 + size * np.sin(1.0 + np.arange(len(p)))))


def test_recovers_what_made_the_data() -> None:
    """Friction constants, under vague priors, to 1e-6. Inertial ones: in the sums that show."""
    arm = replace(pendulum(), tolerance=Tolerance(0.3, 1.0))
    path = SignalPath(arm)
    truth = perturbed(path)
    truth[2] = 0.0  # the centre's offset across the link has no tolerance: it is zero
    found = fit(Residual(path, [clean(path, truth)]), SURE, tolerance=1e-8)
    assert found.ok
    assert found.at_limit == ()
    for key in ("C0", "C1", "C2", "alpha"):
        entry = f"A.friction.{key}"
        true = truth[[e.key for e in path.entries].index(entry)]
        assert found.value(entry) == pytest.approx(true, rel=1e-6)
    m, x, i, r = (found.value(f"A.{key}") for key in ("mass", "com_x", "inertia", "rotor_inertia"))
    names = {e.key: v for e, v in zip(path.entries, truth, strict=True)}
    tm, tx, ti, tr = (names[f"A.{key}"] for key in ("mass", "com_x", "inertia", "rotor_inertia"))
    assert m * x == pytest.approx(tm * tx, rel=1e-6)
    assert i + r + m * x**2 == pytest.approx(ti + tr + tm * tx**2, rel=1e-6)
    assert np.abs(found.residual).max() < 1e-6


@pytest.mark.parametrize("ends", ["above its start", "at its start"])
@pytest.mark.parametrize("careful", [True, False])
def test_a_fit_that_finds_nothing_better_than_its_start_is_done_again(
    careful: bool, ends: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    solved, tried = map_fit._solved, []

    def lost(problem: Problem, evaluations: int, tolerance: float, steps: Mapping[str, object]) -> Any:
        tried.append(steps)
        if len(tried) > 1:
            return solved(problem, evaluations, tolerance, steps)
        problem.evaluate(problem.start)
        far = problem.bounds()[1].clip(max=1.0)
        problem.evaluate(far)
        return (far, "Solve_Succeeded") if ends == "above its start" else (problem.start, "Restoration_Failed")

    monkeypatch.setattr(map_fit, "_solved", lost)
    path = SignalPath(replace(pendulum(), tolerance=Tolerance(0.3, 1.0)))
    truth = perturbed(path, 0.05)
    found = fit(Residual(path, [clean(path, truth)]), SURE, careful=careful)
    assert tried == ([CAREFUL, BOLD] if careful else [BOLD, CAREFUL])
    assert found.value("A.friction.C0") == pytest.approx(truth[[e.key for e in path.entries].index("A.friction.C0")])


def test_recovers_an_effect_in_its_logarithm() -> None:
    place = Placed(registry()["presliding"], 0, {"stiffness": 350.0, "damping": 2.0})
    path = SignalPath(pendulum(), [place])
    truth = values_of(path.entries)
    start = truth.copy()
    start[-2:] = 1200.0, 0.5
    found = fit(Residual(path, [clean(path, truth)]), SURE, start, {}, tolerance=1e-8)
    assert found.ok
    assert found.p[-2:] == pytest.approx([350.0, 2.0], rel=1e-5)


def rougher(factor: float) -> tuple[SignalPath, Fit, Entry]:
    """A fit to data of a joint whose C0 is a multiple of its nominal value, and what the arm says of that."""
    path = SignalPath(pendulum())
    truth = values_of(path.entries)
    i = [entry.key for entry in path.entries].index("A.friction.C0")
    truth[i] *= factor
    return path, fit(Residual(path, [clean(path, truth)]), SURE), path.entries[i]


def test_stays_within_its_limits_and_says_so() -> None:
    """Friction of twenty times its nominal value, with a tolerance of 30 %: held at its limit, and reported."""
    path, found, entry = rougher(20.0)
    assert "A.friction.C0" in found.at_limit
    assert found.value("A.friction.C0") == pytest.approx(entry.value + LEVEL_LIMIT * entry.sd, rel=1e-3)
    others = [(v, e) for v, e in zip(found.p, path.entries, strict=True) if e.sd > 0.0 and e.owner != "friction"]
    assert max(abs(v - e.value) / e.sd for v, e in others) <= PRIOR_LIMIT + 1e-9


def test_friction_of_several_times_its_nominal_value_is_retuned() -> None:
    """Whatever its tolerance says: other laws of friction would stand in for its level."""
    _, found, entry = rougher(5.0)
    assert found.value("A.friction.C0") == pytest.approx(5.0 * entry.value, rel=0.01)
    assert found.at_limit == ("A.friction.C0",)  # beyond three deviations all the same, which is said


class Runaway(Residual):
    """A residual that is beyond all numbers as soon as the mass leaves its nominal value far behind."""

    tried = 0

    def __call__(self, p: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        r, jacobian = super().__call__(p)
        away = p[0] > 2.05
        self.tried += away
        return (np.full_like(r, 1e200), np.full_like(jacobian, 1e200)) if away else (r, jacobian)


@pytest.mark.parametrize("dear", [False, True])
def test_a_trial_step_that_runs_away_is_taken_back_in_silence(capfd: pytest.CaptureFixture[str], dear: bool) -> None:
    path = SignalPath(pendulum())
    truth = values_of(path.entries)
    truth[0] *= 1.2
    residual = Runaway(path, [clean(path, truth)])
    residual.dear = dear
    found = fit(residual, SURE)
    assert residual.tried > 0
    assert np.isfinite(found.cost)
    assert 2.0 < found.value("A.mass") <= 2.05
    assert capfd.readouterr() == ("", "")


def test_a_fit_that_has_run_away_for_good_is_as_bad_as_can_be_in_silence(capfd: pytest.CaptureFixture[str]) -> None:
    path = SignalPath(pendulum())
    away = values_of(path.entries)
    away[0] = 2.1
    found = fit(Runaway(path, [clean(path, away)]), SURE, away)
    assert found.cost == np.inf
    assert not found.ok
    assert capfd.readouterr() == ("", "")


def test_held_values_do_not_move() -> None:
    path = SignalPath(pendulum())
    found = fit(Residual(path, [clean(path, perturbed(path))]), SURE)
    held = [i for i, entry in enumerate(path.entries) if entry.sd == 0.0]
    assert held
    assert (found.p[held] == values_of(path.entries)[held]).all()
    assert not set(held) & set(found.free)


def test_where_all_values_are_held_there_is_a_residual_all_the_same() -> None:
    """Told for the values of the arm file, and with it their intervals: none."""
    path = SignalPath(replace(pendulum(), tolerance=Tolerance(0.0, 0.0)))
    residual = Residual(path, [clean(path, perturbed(path))])
    found = fit(residual, SURE)
    left, jacobian = residual(values_of(path.entries))
    assert found.ok
    assert found.residual == pytest.approx(left)
    assert found.cost == pytest.approx(0.5 * np.sum((left / SURE.sd) ** 2))
    assert found.jacobian.shape == jacobian.shape == (*left.shape, 0)
    bounds = intervals(found, SURE, np.arange(len(left)) // 50)
    assert bounds.low == pytest.approx(found.p)
    assert bounds.high == pytest.approx(found.p)
    assert not bounds.identified.any()


def test_stays_within_physical_bounds() -> None:
    """Data of a joint that would need negative friction: C0 rests on zero."""
    path = SignalPath(replace(pendulum(), tolerance=Tolerance(0.1, 10.0)))
    truth = values_of(path.entries)
    truth[[e.key for e in path.entries].index("A.friction.C0")] = -1.0
    found = fit(Residual(path, [clean(path, truth)]), SURE)
    for value, entry in zip(found.p, path.entries, strict=True):
        assert entry.lower <= value <= entry.upper
    assert found.value("A.friction.C0") == pytest.approx(0.0, abs=1e-3)


def test_prior_weighs_against_the_data() -> None:
    """With weak data a value stays near the nominal one; with strong data it goes where they say."""
    path = SignalPath(pendulum())
    truth = perturbed(path)
    run = clean(path, truth)
    vague, sure = fit(Residual(path, [run]), Weights(np.array([1e3]), np.ones(1))), fit(Residual(path, [run]), SURE)
    assert vague.value("A.friction.C2") == pytest.approx(0.7, rel=1e-3)
    assert abs(sure.value("A.friction.C2") - 0.7) > 0.01
    assert vague.prior < 1e-6
    assert sure.prior > 0.1


def test_correlated_rows_count_for_less() -> None:
    weights = Weights(np.array([0.5, 2.0]), np.array([4.0, 9.0]))
    assert weights.scale == pytest.approx([1.0, 1.0 / 6.0])


def test_cost_is_what_it_says() -> None:
    path = SignalPath(pendulum())
    run = condition(pendulum(), recorded(stronger(PENDULUM, C0=1.4, mass=1.1), rate=250.0, noise=1e-5), 20.0)
    found = fit(Residual(path, [run]), Weights(np.array([0.1]), np.array([2.0])))
    assert found.misfit == pytest.approx(0.5 * np.sum(found.residual**2) / 0.01 / 2.0)
    assert found.cost == found.misfit + found.prior
    nominal = Residual(path, [run])(values_of(path.entries))[0]
    assert found.misfit < 0.1 * 0.5 * np.sum(nominal**2) / 0.01 / 2.0
    z = [(v - e.value) / e.sd for v, e in zip(found.p, path.entries, strict=True) if e.sd > 0.0]
    assert found.prior == pytest.approx(0.5 * np.sum(np.square(z)))


def test_gradient_is_zero_at_the_solution() -> None:
    """The optimality condition, from the returned Jacobian: data and prior pull equally, in units of one."""
    path = SignalPath(pendulum())
    run = clean(path, perturbed(path))
    run = replace(run, command=run.command + 0.3 * np.random.default_rng(0).standard_normal(run.command.shape))
    weights = Weights(np.array([0.1]), np.array([2.0]))
    found = fit(Residual(path, [run]), weights, tolerance=1e-7)
    assert found.ok
    assert found.at_limit == ()
    entries = [path.entries[i] for i in found.free]
    sd = np.array([entry.sd for entry in entries])
    z = (found.p[found.free] - np.array([entry.value for entry in entries])) / sd
    pull = np.einsum("mn,mnf->f", found.residual * weights.scale**2, found.jacobian) * sd + z
    assert np.abs(pull).max() < 1e-3


def test_failed_solve_is_not_ok() -> None:
    """Two evaluations are not enough: the status says so, and the best point met is returned."""
    path = SignalPath(replace(pendulum(), tolerance=Tolerance(0.5, 2.0)))
    residual = Residual(path, [clean(path, perturbed(path, 0.4))])
    found = fit(residual, SURE, evaluations=2, tolerance=1e-12)
    assert not found.ok
    assert found.status not in ("Solve_Succeeded", "Solved_To_Acceptable_Level")
    nominal = 0.5 * np.sum(residual(values_of(path.entries))[0] ** 2) * SURE.scale[0] ** 2
    assert found.cost <= nominal


def test_several_joints_and_runs() -> None:
    """Two joints, two runs of different rates; each joint's own constants are found."""
    a = Joint("A", "revolute", 0.3, 2.0, (0.15, 0.0), 0.03, 0.05, *[Friction(2.0, 0.5, 0.7, 0.05)] * 2)
    b = replace(a, name="B", mass=1.0, friction=Friction(1.0, 0.3, 0.4, 0.08), backward=Friction(1.0, 0.3, 0.4, 0.08))
    arm = Arm("two", (9.81, 0.0), (a, b), tolerance=Tolerance(0.5, 2.0))
    path = SignalPath(arm)
    truth = perturbed(path, 0.1)
    made = []
    for rate in (200.0, 250.0):
        one = condition(pendulum(), recorded(rate=rate, duration=4.0), 20.0)
        other = condition(pendulum(), recorded(rate=rate, duration=4.0), 20.0)
        other = replace(
            other, position=0.7 * other.position + 0.1, velocity=0.7 * other.velocity,
            acceleration=0.7 * other.acceleration,
        )  # fmt: skip
        lagged = np.roll(np.arange(len(one.time)), 97)
        both = {
            name: np.concatenate([getattr(one, name), getattr(other, name)[lagged]], axis=1)
            for name in ("position", "velocity", "acceleration", "command", "stuck", "sliding", "velocity_sd")
        }
        joints = {name: np.repeat(getattr(one, name), 2) for name in ("noise", "undriven", "braked")}
        made.append(made_by(path, truth, replace(one, **both, **joints)))
    weights = Weights(np.full(2, 1e-4), np.ones(2))
    found = fit(Residual(path, made), weights, tolerance=1e-8)
    for i, entry in enumerate(path.entries):
        if entry.owner == "friction":
            assert found.p[i] == pytest.approx(truth[i], rel=1e-4)


def test_a_step_that_runs_away_costs_without_end_and_warns_nobody() -> None:
    """IPOPT turns back there."""
    path = SignalPath(pendulum())
    residual = Residual(path, [clean(path, perturbed(path))])
    problem = Problem(residual, Weights(np.array([1e-307]), np.ones(1)), values_of(path.entries), {})
    cost, _, _ = problem.evaluate(problem.start)
    assert not np.isfinite(cost)


@pytest.mark.parametrize("side", ["lower", "upper"])
@pytest.mark.parametrize("name", ["history", "presliding", "joint_flexibility", "torque_ripple"])
def test_where_a_fit_rests_on_a_bound_an_arm_file_may_have_it(name: str, side: str) -> None:
    """To the last digit: a corrected arm file is read back."""
    path = SignalPath(pendulum(), [Placed(registry()[name], 0)])
    run = condition(pendulum(), recorded(rate=250.0), 20.0, np.full(1, 1.6e-11))
    columns = [i for i, entry in enumerate(path.entries) if isinstance(entry.owner, int)]
    problem = Problem(Residual(path, [run], columns), SURE, values_of(path.entries), {})
    p = problem.physical(problem.bounds()[side == "upper"])
    assert all(path.entries[i].lower <= p[i] <= path.entries[i].upper for i in columns)
