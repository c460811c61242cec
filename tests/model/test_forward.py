"""The path forward and the path cut are one model: what one simulates, the other balances."""

from collections.abc import Iterator

import casadi as ca
import numpy as np
import pytest

from stribeck.arm import Arm, Friction, Joint
from stribeck.effects.registry import effect_named, laws, registry
from stribeck.model.balance import Balance
from stribeck.model.cut import Cut
from stribeck.model.drive import DRIVE, Drive
from stribeck.model.effect import Effect
from stribeck.model.forward import Forward
from stribeck.model.layout import Placed, values_of
from stribeck.model.path import SignalPath
from stribeck.model.scale import Scale

SCALE = Scale(torque=4.0, friction=2.0, speed=1.0, travel=2.0, inertia=0.3, sample_time=0.01, length=0.3)


def arm(n: int = 2) -> Arm:
    friction = Friction(2.0, 0.5, 0.7, 0.05)
    backward = Friction(1.7, 0.6, 0.9, 0.07)
    joints = tuple(
        Joint(f"J{j}", "revolute", 0.3, 2.0 + j, (0.15, 0.02), 0.03, 0.05, friction, backward) for j in range(n)
    )
    return Arm("test", (9.81, 1.0), joints)


def trials() -> Iterator[tuple[Effect, dict[str, float]]]:
    for effect in laws().values():
        for values in effect.starts(SCALE)[:1]:
            yield effect, values


def cut_drive(path: SignalPath, p: np.ndarray, y: np.ndarray, rates: np.ndarray, u: np.ndarray) -> np.ndarray:
    """What would be recorded of this instant: exact position, velocity and acceleration of the sensor."""
    n = path.n
    q, dq, ddq = ca.SX.sym("q", n), ca.SX.sym("dq", n), ca.SX.sym("ddq", n)
    seen = ca.vertcat(*[path.measured(j, q[j]) for j in range(n)])
    speed = ca.jtimes(seen, q, dq)
    acceleration = ca.jtimes(speed, ca.vertcat(q, dq), ca.vertcat(dq, ddq))
    record = ca.Function("record", [q, dq, ddq, path.p], [seen, speed, acceleration])
    values = [v.full().ravel() for v in record(y[:n], y[n : 2 * n], rates[n : 2 * n], p)]
    return record_of(*values, u)


def record_of(position: np.ndarray, velocity: np.ndarray, acceleration: np.ndarray, command: np.ndarray) -> np.ndarray:
    """One instant as the cut takes it, known exactly."""
    known = {"time": np.zeros(1), "position": position, "velocity": velocity, "acceleration": acceleration}
    known |= {"command": command, "velocity_sd": np.full(len(position), 1e-12), "sliding": np.ones(len(position))}
    return np.concatenate([known.get(name, np.zeros(len(position))) for name in DRIVE])


def check_balance(placed: list[Placed], inverted: float = 1e-9) -> None:
    """Accelerations and state rates of random sliding states leave no residual at the cut."""
    rng = np.random.default_rng(1)
    path = SignalPath(arm(), placed)
    forward, sample, p = Forward(path), Balance(path), values_of(path.entries)
    drive = Drive.symbols(2)
    balance = ca.Function(
        "balance",
        [drive.stacked, sample.x, path.p, sample.delay_at],
        [sample.residual(drive, sample.x)[0], sample.derivatives(drive, sample.x)],
    )
    for _ in range(8):
        y = np.concatenate([rng.normal(size=2), rng.normal(size=2), 0.3 * rng.normal(size=path.x.numel())])
        for i, j in enumerate(path.flexible):  # a link near its motor
            y[4 + 2 * i : 6 + 2 * i] = y[[j, 2 + j]] + 0.02 * rng.normal(size=2)
        u = 5.0 * rng.normal(size=2)
        rates = forward.flow(0.0, y, np.sign(y[2:4]), u, p)[0].full().ravel()
        assert np.isfinite(rates).all()
        recorded = cut_drive(path, p, y, rates, u)
        delays = np.array([place.values.get("time", 0.0) for place in path.placed])
        slowing = [rates[2 + j] - rates[5 + 2 * i] for i, j in enumerate(path.flexible)] if sample.contacts else []
        bending = [sum(rates[4 + i] for i in bristle_rows(path, j)) for j in sample.bristled]
        residual, derivatives = balance(recorded, np.concatenate([y[4:], slowing, bending]), p, delays)
        size = 1.0 + np.abs(rates).max() * 0.3
        assert residual.full().ravel() == pytest.approx([0.0, 0.0], abs=inverted * size)
        assert derivatives.full().ravel() == pytest.approx(rates[4:], rel=1e-9, abs=1e-9 * size)


def bristle_rows(path: SignalPath, joint: int) -> list[int]:
    k, effect = path.bristle(joint)  # type: ignore[misc]
    return [path.state_index(f"{k}.{name}") for name in effect.states]


@pytest.mark.parametrize(("effect", "values"), [pytest.param(e, v, id=e.label) for e, v in trials()])
def test_forward_balances_the_cut(effect: Effect, values: dict[str, float]) -> None:
    inverted = 2e-4 if effect.channel == "sensing" else 1e-9  # the cut undoes a sensor's law by fixed point
    check_balance([Placed(effect, joint, values) for joint in effect.sites(2)], inverted)


@pytest.mark.parametrize("load", ["proportional", "directional", "motor", "net", "weight"])
@pytest.mark.parametrize(
    ("name", "law"), [("base_flexibility", "rocking"), ("base_flexibility", "sliding"), ("joint_flexibility", "")]
)
def test_it_does_so_where_friction_grows_with_the_load_of_what_yields(name: str, law: str, load: str) -> None:
    soft, rubs = effect_named(name, law), effect_named("load_dependent_friction", load)
    yields = Placed(soft, 0, soft.starts(SCALE)[0])
    check_balance([yields, *(Placed(rubs, j, {"ratio": 0.3}) for j in (0, 1))])


@pytest.mark.parametrize("effect", [pytest.param(e, id=e.label) for e in laws().values()])
def test_stuck_joint_is_masked(effect: Effect) -> None:
    """Modes 0: no velocity, no acceleration, and the same break-away margin as a joint that is free to move."""
    path = SignalPath(arm(), [Placed(effect, joint, effect.starts(SCALE)[0]) for joint in effect.sites(2)])
    forward, p = Forward(path), values_of(path.entries)
    rng = np.random.default_rng(2)
    y = np.concatenate([rng.normal(size=2), [0.0, 0.8], 0.1 * rng.normal(size=path.x.numel())])
    rates = forward.flow(0.0, y, [0.0, 1.0], [1.0, 2.0], p)[0].full().ravel()
    assert rates[0] == 0.0
    assert rates[2] == 0.0
    assert rates[3] != 0.0
    if not forward.bristles[0]:
        torque = np.linspace(-40.0, 40.0, 17)
        for u in torque:  # where the margin is gone, the freed joint accelerates in that direction, else not
            up, down = forward.flow(0.0, y, [0.0, 1.0], [u, 2.0], p)[1].full().ravel()[[0, 2]]
            for margin, way in ((up, 1.0), (down, -1.0)):
                a = way * float(forward.flow(0.0, y, [way, 1.0], [u, 2.0], p)[0][2])
                assert (a > 0) == (margin < 0)


def test_jacobian() -> None:
    effects = registry()
    placed = [Placed(effects["presliding"], 0, {"stiffness": 900.0, "damping": 2.0})]
    placed += [Placed(effects["load_dependent_friction"], 1, {"ratio": 0.4})]
    path = SignalPath(arm(), placed)
    forward, p = Forward(path), values_of(path.entries)
    y, modes, u = np.array([0.3, -0.5, 0.4, -0.9, 0.7]), np.array([1.0, -1.0]), np.array([3.0, -2.0])
    exact = forward.jacobian(0.0, y, modes, u, p).full()

    def rates(y: np.ndarray, u: np.ndarray) -> np.ndarray:
        return np.asarray(forward.flow(0.0, y, modes, u, p)[0].full().ravel())

    for i in range(7):
        step = np.zeros(7)
        step[i] = 1e-6
        difference = (rates(y + step[:5], u + step[5:]) - rates(y - step[:5], u - step[5:])) / 2e-6
        assert exact[:, i] == pytest.approx(difference, rel=1e-6, abs=1e-5)
    assert (exact[:, 7] == 0.0).all()


@pytest.mark.parametrize("ratio", [0.1, 0.5, 0.9])
@pytest.mark.parametrize("law", ["proportional", "directional", "motor", "net"])
def test_algebraic_loop_of_load_dependent_friction(law: str, ratio: float) -> None:
    """Friction that depends on the load, which depends on the acceleration, or itself as well: solved, not lagged."""
    place = Placed(effect_named("load_dependent_friction", law), 0, {"ratio": ratio})
    path, plain = SignalPath(arm(), [place, Placed(place.effect, 1, place.values)]), SignalPath(arm())
    forward, p, p0 = Forward(path), values_of(path.entries), values_of(plain.entries)
    reference = Cut(plain, 0.01)
    rng = np.random.default_rng(4)
    for _ in range(30):
        y, u = np.concatenate([rng.normal(size=2), 2 * rng.normal(size=2)]), 10 * rng.normal(size=2)
        way = np.sign(y[2:])
        rates = forward.flow(0.0, y, way, u, p)[0].full().ravel()
        more, stages = reference.balance(record_of(y[:2], y[2:], rates[2:], u), np.zeros(0), p0, np.zeros(0))
        load, extra = stages.full().ravel()[4:6], way * more.full().ravel()
        passed = way * load
        sides = [j.friction if v > 0.0 else j.backward for j, v in zip(arm().joints, y[2:], strict=True)]
        dry = extra + [f.C0 + f.C1 * np.exp(-abs(v) / f.alpha) for f, v in zip(sides, y[2:], strict=True)]
        if law == "directional":
            passed += dry + [f.C2 * abs(v) for f, v in zip(sides, y[2:], strict=True)]
        passed = {"motor": u, "net": way * u - dry}.get(law, passed)
        assert extra == pytest.approx(ratio * np.abs(passed), rel=1e-9, abs=1e-9)


@pytest.mark.parametrize(("law", "joints"), [("one_joint", [0]), ("all_joints", [0, 1])])
def test_a_late_record_delays_the_commands_of_the_joints_it_is_of(law: str, joints: list[int]) -> None:
    path = SignalPath(arm(), [Placed(effect_named("time_shift", law), 0)])
    assert [joint for joint, _ in Forward(path).delays] == joints
    assert {path.entries[i].name for _, i in Forward(path).delays} == {"time"}
