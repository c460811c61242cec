"""Question: does a PID loop hunt though friction is under-compensated? With stiction yes, at every ratio below 1.

Method: joint A (Stribeck) and the same joint with Coulomb friction alone, Kp 30, critical damping, regulation from 0.5
rad, compensation k < 1 on measured velocity, none at rest; shooting on the event-driven return map with its sticking
phases, the integral's wait for break-away in them.
Expected: joint A hunts for every k below 1, 91 mrad at k = 0.9 and Ki = 30, stuck most of the time; with Ki = 0 it
rests. With Coulomb friction alone it rests without compensation; one that is off at rest leaves a break-away above the
friction in motion, which is stiction again. A describing function, which has no sticking phase, predicts none of these
cycles.
Source: paper, 4.3.2; Armstrong and Amin 1996; Hensen, van de Molengraft and Steinbuch 2003.
"""

from __future__ import annotations

import numpy as np
import typer
from _cycles import branches_figure, joint, loop
from _output import write

from stribeck.loop.exact.branch import continue_in
from stribeck.loop.exact.shooting import shoot

RATIOS = np.linspace(0.0, 0.95, 9)
GAINS = (10.0, 30.0)


def main() -> None:
    """Follow the cycle along k for each integral gain; write the answers and the figure."""
    branch = {ki: continue_in(joint("A"), loop(0.0, "zero", ki=ki), "A", "k", RATIOS) for ki in GAINS}
    known = shoot(joint("A"), loop(0.9, "zero", ki=30.0))["A"]
    still = shoot(joint("A"), loop(0.9, "zero"))["A"]
    smooth = {ki: continue_in(joint("Coulomb"), loop(0.0, "zero", ki=ki), "A", "k", RATIOS) for ki in GAINS}
    result = {
        "known": {
            "verdict": known.verdict, "amplitude": known.amplitude, "period": known.period,
            "stick_fraction": known.stick_fraction, "multipliers": [abs(m) for m in known.multipliers],
        },
        "without_integral": {"verdict": still.verdict, "error": still.steady_error},
        "without_stiction": {f"ki_{ki:g}": [c.verdict for c in cycles] for ki, cycles in smooth.items()},
        "branches": {
            f"ki_{ki:g}": [{"k": k, "verdict": c.verdict, "amplitude": c.amplitude, "period": c.period}
                           for k, c in zip(RATIOS.tolist(), cycles, strict=True)]
            for ki, cycles in branch.items()
        },
    }  # fmt: skip
    sizes = {
        f"Ki {ki:g}": (RATIOS, [c.amplitude and 1e3 * c.amplitude for c in cycles]) for ki, cycles in branch.items()
    }
    times = {f"Ki {ki:g}": (RATIOS, [c.period for c in cycles]) for ki, cycles in branch.items()}
    panels = {
        "More compensation, larger swings": ("ratio k", "amplitude, mrad", sizes, {}),
        "and less time stuck between them": ("ratio k", "period, s", times, {}),
    }
    figure = branches_figure(panels, "Under-compensated, a PID loop hunts at every ratio (Ki in N m/(rad s))")
    print(f"written to {write('hunting', result, branches=figure)}")


if __name__ == "__main__":
    typer.run(main)
