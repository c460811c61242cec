"""Question: does over-compensation of friction cause a limit cycle? Only on measured velocity, by rule and damping.

Method: one joint of 1 kg m^2, Kp 30, regulation; shooting on the event-driven return map from small and large starts.
Feedforward and feedback compensation at ratios k; the critical k by bisection, for each rule of what the law does at
velocity zero; amplitudes against the coth law of Coulomb friction.
Expected: feedforward rests for every k, and leaves the velocity below which a ramp sticks and slips. Feedback cycles
over k = 1 (set-valued, or the error's sign), 2/(1 + rho) (zero at rest) and 1/rho (hold), rho the shrinkage of half a
swing, with A = (k-1) C0/Kp coth(pi zeta/(2 sqrt(1-zeta^2))); joint A at zeta 0.5 and k 1.3: 75.7 mrad. At zeta 1 it
rests (k-1) Fs/Kp off; over k = 1 + Kv/C2 growth is unbounded.
Source: paper, 4.3.2; Canudas de Wit et al. 1991.
"""

from __future__ import annotations

import math

import numpy as np
import typer
from _cycles import branches_figure, joint, loop, rho
from _output import write

from stribeck.loop.exact.branch import continue_in
from stribeck.loop.exact.critical import fold_velocity, k_critical
from stribeck.loop.exact.shooting import shoot

RULES = {"set-valued": "set_valued", "zero": "zero", "hold": "hold"}
DAMPING = np.array([0.1, 0.2, 0.3, 0.4])
RATIOS = np.linspace(1.05, 1.5, 10)


def law(ratio: np.ndarray, zeta: float) -> np.ndarray:
    """Return the coth law's amplitude for 5 N m of Coulomb friction, mrad."""
    return 1e3 * (ratio - 1.0) * 5.0 / 30.0 / math.tanh(math.pi * zeta / (2.0 * math.sqrt(1.0 - zeta**2)))


def known_ratios(zeta: np.ndarray) -> dict[str, np.ndarray]:
    """Return the critical ratios in closed form."""
    r = np.array([rho(z) for z in zeta])
    return {"set-valued": np.ones_like(r), "zero": 2.0 / (1.0 + r), "hold": 1.0 / r}


def main() -> None:
    """Ask each question, write the answers and the figure."""
    ahead = [shoot(joint("A"), loop(k, kind="feedforward", zeta=z))["A"].verdict for k in (1.2, 2.0) for z in (0.2, 1)]
    folds = [fold_velocity(joint("B"), loop(k, kind="feedforward"), "A") for k in (0.5, 1.5)]
    critical = {
        n: [k_critical(joint("Coulomb"), loop(1.0, rule, zeta=z), "A") for z in DAMPING] for n, rule in RULES.items()
    }
    expected, fine = known_ratios(DAMPING), np.linspace(0.08, 0.42, 50)
    branch = {z: continue_in(joint("Coulomb"), loop(1.0, zeta=z), "A", "k", RATIOS) for z in (0.3, 0.6)}
    sizes = {f"ζ {z:g}": (RATIOS, [1e3 * c.amplitude for c in cycles]) for z, cycles in branch.items()}
    fed = [shoot(joint("Coulomb"), loop(k, kind="feedforward", zeta=0.3))["A"] for k in RATIOS]
    sizes_fed = [1e3 * (c.amplitude or 0.0) for c in fed]
    laws = {f"ζ {z:g}": (RATIOS, law(RATIOS, z)) for z in branch}
    known, rest = shoot(joint("A"), loop(1.3, zeta=0.5))["A"], shoot(joint("A"), loop(1.3))["A"]
    limit = 1.0 + 2.0 * 0.3 * math.sqrt(30.0) / 1.5
    growth = [shoot(joint("A"), loop(limit * share, zeta=0.3))["A"].verdict for share in (0.97, 1.03)]
    result = {
        "feedforward": ahead + [c.verdict for c in fed], "fold_velocity_by_ratio": folds, "critical": critical,
        "critical_off": max(float(np.max(np.abs(np.array(critical[n]) / expected[n] - 1.0))) for n in RULES),
        "coth_off": max(float(np.max(np.abs(np.array(sizes[n][1]) / laws[n][1] - 1.0))) for n in sizes),
        "zeta_0.5": {"verdict": known.verdict, "amplitude": known.amplitude, "period": known.period},
        "zeta_1": {"verdict": rest.verdict, "error": rest.steady_error}, "unbounded": {"limit": limit, "about": growth},
    }  # fmt: skip
    panels = {
        "Where cycles begin, by the rule at rest": (
            "damping ratio ζ", "critical ratio k", {n: (DAMPING, v) for n, v in critical.items()},
            {n: (fine, v) for n, v in known_ratios(fine).items()}),
        "How large they are; line: coth law": (
            "ratio k", "amplitude, mrad", {**sizes, "fed ahead": (RATIOS, sizes_fed)}, laws),
    }  # fmt: skip
    figure = branches_figure(
        panels,
        "Over-compensation cycles only on measured velocity; fed ahead, it never does",
    )
    print(f"written to {write('over_compensation', result, branches=figure)}")


if __name__ == "__main__":
    typer.run(main)
