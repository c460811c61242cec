"""Question: how fast is the engine beside MuJoCo and scipy, and do batches use both cores? 9,000 times real time.

Method: the paper's two-link arm under a sampled PD at 80 Hz, a sine that reverses, sticks and breaks away; one thread
each, works in turn in one process, in processor time, so that a busy machine does not count. MuJoCo: frictionloss at
the break-away level, steps of half a millisecond, the loop in Python. scipy: `solve_ivp` (RK45, 1e-9) with events on
the same equations, 2 s of the 100. A batch of 1,000 runs with one job and with two, in wall time.
Expected: at least 200 times real time; positions equal to scipy's to 1e-6 rad; MuJoCo, whose friction is a soft
constraint, creeps where the joint should stick; a batch takes 0.5 to 0.7 of the time on two cores that are idle.
Without MuJoCo (pip install mujoco) its part is skipped and said to be.
Source: the project's own acceptance figures; Todorov (2014).
"""

from __future__ import annotations

import os

os.environ["OMP_NUM_THREADS"] = "1"  # read when numpy is first imported

from importlib.util import find_spec

import numpy as np
import typer
from _measure import fastest, in_turn, processor
from _output import write
from _paper import SAMPLE, bench
from _rivals_simulation import AMPLITUDE, FREQUENCY, KP, by_mujoco, by_scipy, mujoco_creep, mujoco_model
from _speed_figure import speed_figure
from rich import print as show

from stribeck.simulate import JointLoop, Loop, Reference, close_loop, simulate_many

SINE = Reference("sine", amplitude=AMPLITUDE, frequency=FREQUENCY)


def loop(duration: float, seed: int = 0, noise: float = 0.0) -> Loop:
    """Return the loop around both joints."""
    gains = zip("AB", KP.tolist(), strict=True)
    joints = tuple(JointLoop(name, kp, SINE, kv=2.0 * kp**0.5, encoder_noise=noise) for name, kp in gains)
    return Loop(SAMPLE, duration, joints, seed=seed)


def main(runs: int = 1000, each: float = 5.0, repeats: int = 5) -> None:
    """Time all; ``--runs N`` sets the size of the batch, ``--each S`` its duration."""
    engine, long, short = bench(), loop(100.0), loop(2.0)
    found = close_loop(engine, long)
    ours = fastest(lambda: close_loop(engine, long), repeats, processor)
    scipy_positions, events = by_scipy(2.0)
    mine, theirs = in_turn(lambda: close_loop(engine, long), lambda: by_scipy(2.0), 3, processor)
    result = {
        "load_average": os.getloadavg()[0],
        "times_real_time": long.duration / ours,
        "events_a_second": found.motion.event_count / long.duration,
        "scipy": {
            "times_slower": theirs / short.duration / (mine / long.duration),
            "events": events,
            "largest_difference_rad": float(np.abs(scipy_positions - close_loop(engine, short).motion.q[:-1]).max()),
        },
    }
    if find_spec("mujoco"):
        model = mujoco_model()
        mine, theirs = in_turn(lambda: close_loop(engine, long), lambda: by_mujoco(100.0, model), 3, processor)
        result["mujoco"] = {"times_slower": theirs / mine, "creep_rad_in_100_s_at_0.9": mujoco_creep(model)}
    else:
        result["mujoco"] = "skipped: pip install mujoco"
    many = [loop(each, seed, 2e-5) for seed in range(runs)]
    one, two = in_turn(lambda: simulate_many(engine, many, jobs=1), lambda: simulate_many(engine, many, jobs=2), 3)
    result["batch"] = {"runs": runs, "one_job_s": one, "two_jobs_s": two, "two_over_one": two / one}
    show(result)
    print(f"written to {write('simulation_speed', result, speeds=speed_figure(result))}")


if __name__ == "__main__":
    typer.run(main)
