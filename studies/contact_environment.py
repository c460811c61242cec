"""Question: does friction read true while the tip presses on a wall (equations 5, 6)? Yes, with J^T F taken off.

Method: both joints of the paper's arm move slowly under PD, the tip meets a wall of 300 N/m that the force sensor
(0.2 N of noise) measures; the arm's own friction acts. Friction is read as applied torque less inertial torque less
J^T F_tip, over the last second in contact; once without the tip force, as in free motion. The Jacobian is checked
against differences.
Expected: within 1 % of Tustin's curve at the joints' velocities with the tip force, off by the whole contact torque
without. Equation (5) is printed with "= tau_tipforce" where the third of its "3 components" is to be added: as
printed, the joint would be in balance with the wall alone.
Source: paper, section 3, equations (5) and (6).
"""

from __future__ import annotations

import numpy as np
import typer
from _contact import jacobian, press, tip
from _contact_figure import contact_figure
from _output import write
from _paper import bench, constants

from stribeck.identify.conditioning import condition
from stribeck.identify.residual import Residual
from stribeck.identify.tustin_fit import tustin

START, VELOCITY, WALL = np.array([0.2, 0.5]), np.array([0.06, 0.05]), 0.285
LAST = slice(-1050, -50)  # the last second, the smoothing's edge left out


def jacobian_error(q: np.ndarray, step: float = 1e-6) -> float:
    """Return how far the Jacobian is from central differences of the tip's position, m."""
    columns = [(tip(q + step * e) - tip(q - step * e)) / (2 * step) for e in np.eye(2)]
    return float(np.abs(np.stack(columns, axis=1) - jacobian(q)).max())


def main(seed: int = 3) -> None:
    """Press, read friction three ways, write."""
    engine = bench()
    made = press(START, VELOCITY, 6.0, WALL, 0.2, seed)
    data = condition(engine.path.arm, made.run, 20.0)
    stages = Residual(engine.path, [data], ()).stages(data, engine.p)
    applied = stages["actuator"] - stages["rotor"] - stages["load"]  # the applied torque less the inertial one
    at_tip = -np.einsum("kij,ki->kj", np.stack([jacobian(q) for q in made.run.q]), made.force)  # what the wall takes
    speed = data.velocity[LAST].mean(axis=0)
    true = np.array([tustin(constants(joint), speed[j : j + 1])[0] for j, joint in enumerate("AB")])
    read = {"with_tip_force": applied - at_tip, "without": applied, "equation_5_as_printed": at_tip}
    result = {
        "seed": seed,
        "units": {"friction": "N m", "tip_force": "N", "jacobian_error": "m", "error": "relative"},
        "tip_force": float(np.abs(made.force[LAST, 1]).mean()),
        "tip_torque": at_tip[LAST].mean(axis=0).tolist(),
        "speed": speed.tolist(),
        "true": true.tolist(),
        "friction": {way: values[LAST].mean(axis=0).tolist() for way, values in read.items()},
        "error": {way: (values[LAST].mean(axis=0) / true - 1.0).tolist() for way, values in read.items()},
        "jacobian_error": jacobian_error(made.run.q[-1]),
    }
    folder = write("contact_environment", result, friction=contact_figure(made, applied, at_tip, true))
    print(result["error"], f"written to {folder}")


if __name__ == "__main__":
    typer.run(main)
