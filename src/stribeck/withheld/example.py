"""The recording that ships with the package: a two-link arm with tight spots in joint A, a late drive in joint B."""

from __future__ import annotations

import json
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import numpy as np

from stribeck.arm import Arm, Friction, Joint, save_arm
from stribeck.run import Run, save_run
from stribeck.withheld.arms import misinformed
from stribeck.withheld.excitation import programme
from stribeck.withheld.injections import Injection
from stribeck.withheld.recorder import default_gains, record

SEED = 20
RATE = 500.0  # Hz
RESOLUTION = 6.0e-6  # rad
NOISE = 1.0e-5  # rad
DURATION = 10.0  # s
MOTIONS = ("slow reversals", "multisine", "point to point", "speed stairs", "via points", "sweep")
EFFECTS = (
    Injection("position_dependent_friction", "A", {"amplitude": 1.5, "harmonic": 3.0, "phase": 0.7}),
    Injection("delay", "B", {"time": 0.012}),
)


def true_arm() -> Arm:
    """Return the arm as it is: direct drive, in a horizontal plane."""
    a, b = Friction(4.6, 1.65, 1.4, 0.06), Friction(2.2, 0.6, 0.8, 0.04)
    return Arm(
        "two-link direct-drive arm",
        (0.0, 0.0),
        (
            Joint("A", "revolute", 0.35, 9.5, (0.19, 0.0), 0.14, 0.25, a, a, 200.0, RESOLUTION),
            Joint("B", "revolute", 0.30, 5.2, (0.16, 0.0), 0.06, 0.08, b, b, 80.0, RESOLUTION),
        ),
        sample_time=1.0 / RATE,
    )


def nominal_arm() -> Arm:
    """Return what its data sheet says: inertial values off by some 10 %, friction by some 20 %."""
    return misinformed(true_arm(), np.random.default_rng(SEED), inertial=0.1, friction=0.2)


def example_runs(effects: tuple[Injection, ...] = EFFECTS) -> tuple[Run, ...]:
    """Return the six runs; with ``effects=()`` the same motions of an arm that hides nothing."""
    nominal = nominal_arm()
    motions = programme(nominal, np.random.default_rng(SEED + 1), MOTIONS, DURATION)
    runs = record(
        true_arm(), effects, motions, rate=RATE, resolution=RESOLUTION, noise=NOISE, gains=default_gains(nominal, 3.5),
        model=nominal, seed=SEED,
    )  # fmt: skip
    return tuple(_rounded(run) for run in runs)


def write_example(folder: Path, truth: Path | None = None, effects: tuple[Injection, ...] = EFFECTS) -> None:
    """Write ``arm.toml`` and ``run_00.csv`` .. to `folder`, and what is hidden in them to the file `truth`."""
    folder.mkdir(parents=True, exist_ok=True)
    save_arm(nominal_arm(), folder / "arm.toml")
    for run in example_runs(effects):
        save_run(run, folder / f"{run.name}.csv")
    if truth is not None:
        truth.write_text(json.dumps(_truth(effects), indent=2) + "\n", encoding="utf-8")


def _truth(effects: tuple[Injection, ...]) -> dict[str, Any]:
    return {
        "effects": [{"effect": e.effect, "joint": e.joint, "parameters": dict(e.params)} for e in effects],
        "arm": asdict(true_arm()),
        "encoder_noise": NOISE,
        "seed": SEED,
        "units": "SI",
    }


def _rounded(run: Run) -> Run:
    """Numbers no longer than they mean something: positions are whole counts, torque to 10 micro-newton metres."""
    return replace(run, t=np.round(run.t, 6), q=np.round(run.q, 7), tau=np.round(run.tau, 5))
