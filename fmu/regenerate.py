"""Write the inputs and the reference results of every model folder here, from the package's own simulator.

Run it after a change of an arm file or of the engine: ``python fmu/regenerate.py``. The engine is run at a tolerance of
1e-11, so that the results are good to about 1e-10 rad.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from stribeck.arm import load_arm
from stribeck.run import save_columns
from stribeck.simulate import Engine, load_loop, path_of, simulate_loop

HERE = Path(__file__).parent
MODELS = ("one_joint", "two_link_nominal", "two_link_corrected")
STEP, DURATION = 0.01, 5.0  # s
TOLERANCE = 1e-11


def torques(n: int) -> tuple[np.ndarray, np.ndarray]:
    """Return instants (M,), s, and torques (M, n), N m, each held to the next row: break-away, sliding, reversals."""
    t = STEP * np.arange(round(DURATION / STEP) + 1)
    size, frequency = np.array([9.0, 4.0]), np.array([0.5, 0.8])  # N m, Hz
    tau = size * np.sin(2.0 * np.pi * frequency * t[:, None]) * np.minimum(t[:, None], 1.0)
    return np.round(t, 6), np.round(tau[:, :n], 3)


def columns(**values: np.ndarray) -> dict[str, np.ndarray]:
    """Return one column a joint: q1, q2, ..."""
    return {f"{key}{k + 1}": array[:, k] for key, array in values.items() for k in range(array.shape[1])}


def reference(model: str) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
    """Return the columns of a model's input.csv and reference.csv."""
    engine = Engine(path_of(load_arm(HERE / model / "arm.toml")))
    t, tau = torques(engine.n)
    motion = engine.run(engine.p, engine.start(engine.p, np.zeros(engine.n)), t, tau, tolerance=TOLERANCE)
    if not motion.ok:
        raise RuntimeError(f"{model}: {motion.status}")
    shown = columns(q=motion.q, dq=motion.dq, tau_friction=motion.friction, sliding=motion.modes)
    return {"t": t, **columns(tau=tau)}, {"t": t, **shown}


def main() -> None:
    """Write every file."""
    for model in MODELS:
        given, result = reference(model)
        save_columns(given, HERE / model / "input.csv")
        save_columns(result, HERE / model / "reference.csv")
    folder = HERE / "two_link_nominal"
    arm = load_arm(folder / "arm.toml")
    closed = simulate_loop(arm, load_loop(folder / "loop.toml", arm), tolerance=TOLERANCE)
    shown = columns(q=closed.measured, tau=closed.command, q_ref=closed.reference)
    save_columns({"t": closed.motion.t, **shown}, folder / "loop_reference.csv")


if __name__ == "__main__":
    main()
