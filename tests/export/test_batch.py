"""The batch driver gives what single simulations give, and says what it cannot do."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from stribeck.arm import Arm
from stribeck.errors import InputError
from stribeck.export.batch import simulate_batch

from .conftest import two_links
from .driver import OK, Fmu

TIMES = 0.01 * np.arange(41)
COMMAND = np.stack([9.0 * np.sin(20.0 * TIMES), 4.0 * np.cos(15.0 * TIMES)], axis=1)
NAMES = {"inputs": ["tau[1]", "tau[2]"], "outputs": ["q[1]", "dq[2]", "sliding[1]"]}


def test_equal_to_single_simulations(nominal: Fmu) -> None:
    values = {"joint[1].mass": np.array([3.0, 4.0, 5.0]), "dq_start[2]": np.array([0.0, 0.2, -0.2])}
    found = simulate_batch(nominal.path, TIMES, COMMAND, values, jobs=2, **NAMES)
    assert (found.reached == len(TIMES)).all()
    for r in range(3):
        it, rows = nominal.instance(), []
        it.begin({name: column[r] for name, column in values.items()} | {"tau[1]": 0.0, "tau[2]": COMMAND[0, 1]})
        for k, t in enumerate(TIMES):
            rows.append(it.get(*NAMES["outputs"]))
            it.put({"tau[1]": COMMAND[k, 0], "tau[2]": COMMAND[k, 1]})
            if k + 1 < len(TIMES):
                assert it.step(t, TIMES[k + 1] - t) == OK
        it.free()
        np.testing.assert_array_equal(found.outputs[r], np.array(rows))


def test_each_with_its_own_command(nominal: Fmu) -> None:
    command = np.stack([COMMAND, 0.5 * COMMAND])
    found = simulate_batch(nominal.path, TIMES, command, {}, jobs=2, **NAMES)
    alone = simulate_batch(nominal.path, TIMES, command[1], {}, jobs=1, **NAMES)
    np.testing.assert_array_equal(found.outputs[1], alone.outputs[0])
    assert np.abs(found.outputs[0] - found.outputs[1]).max() > 1e-3


def test_a_refused_value_ends_its_simulation_alone(nominal: Fmu) -> None:
    found = simulate_batch(nominal.path, TIMES, COMMAND, {"joint[1].mass": np.array([4.0, -1.0, 4.0])}, jobs=1, **NAMES)
    assert found.reached.tolist() == [len(TIMES), 0, len(TIMES)]
    assert np.isnan(found.outputs[1]).all()
    np.testing.assert_array_equal(found.outputs[0], found.outputs[2])


def test_wrong_arguments(nominal: Fmu) -> None:
    with pytest.raises(InputError, match=r"unknown variable: found foo"):
        simulate_batch(nominal.path, TIMES, COMMAND, {}, inputs=["tau[1]", "tau[2]"], outputs=["foo"])
    with pytest.raises(InputError, match="do not fit"):
        simulate_batch(nominal.path, TIMES, COMMAND[:3], {}, **NAMES)


@pytest.mark.slow
def test_sixty_four_instances_in_threads(made: Callable[[Arm, int], Path]) -> None:
    """Nothing is shared between instances: many threads give what one gives."""
    path = made(two_links(), 2)
    mass = np.linspace(3.0, 5.0, 64)
    together = simulate_batch(path, TIMES, COMMAND, {"joint[1].mass": mass}, jobs=64, **NAMES)
    alone = simulate_batch(path, TIMES, COMMAND, {"joint[1].mass": mass}, jobs=1, **NAMES)
    np.testing.assert_array_equal(together.outputs, alone.outputs)
