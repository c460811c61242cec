"""Through fmpy: both kinds, both versions, against the arm's own simulator."""

import numpy as np
from fmpy import simulate_fmu

from stribeck.simulate import Engine

from .driver import Fmu

START = {"dq_start[1]": 0.9, "dq_start[2]": -0.7, "q_start[2]": 0.4, "tau[1]": 7.5, "tau[2]": -1.0}
OUTPUTS = ["q[1]", "q[2]", "sliding[1]", "sliding[2]"]


def own(engine: Engine, times: np.ndarray) -> np.ndarray:
    state = engine.start(engine.p, np.array([0.0, 0.4]), np.array([0.9, -0.7]))
    found = engine.run(engine.p, state, times, np.tile([7.5, -1.0], (len(times), 1)))
    assert found.event_count >= 1
    return found.q


def test_co_simulation(nominal: Fmu, engine: Engine) -> None:
    found = simulate_fmu(
        str(nominal.path), fmi_type="CoSimulation", stop_time=1.0, step_size=0.01, output_interval=0.01,
        relative_tolerance=1e-8, start_values=START, output=OUTPUTS, timeout=60,
    )  # fmt: skip
    q = np.stack([found["q[1]"], found["q[2]"]], axis=1)
    assert np.abs(q - own(engine, np.asarray(found["time"]))).max() < 1e-8


def test_model_exchange(nominal: Fmu, engine: Engine) -> None:
    """With CVode and a constant command, standstill of joint B on the way."""
    found = simulate_fmu(
        str(nominal.path), fmi_type="ModelExchange", solver="CVode", stop_time=1.0, output_interval=0.05,
        relative_tolerance=1e-8, start_values=START, output=OUTPUTS, timeout=60,
    )  # fmt: skip
    times, first = np.unique(found["time"], return_index=True)
    q = np.stack([found["q[1]"], found["q[2]"]], axis=1)[first]
    assert np.abs(q - own(engine, times)).max() < 1e-6
    assert 0.0 in found["sliding[2]"]
