"""Question: what does the paper's ramp of torque (4.1) read as break-away? Some 2 % too much, until it is read back.

Method: 80 Hz; the torque of joint A rises by 0.02 N m a sample, of B by 0.005, the other joint under PID; ten trials
each, friction 5 % different from trial to trial, encoder noise 20 urad. Read as the paper does, at the first sample
whose velocity stands out of the noise, and read back to where the motion began. Then trials without scatter, at the
paper's rate and two and three times as fast, for the bias of either reading.
Expected: mean 6.25 N m for A and 2.8 N m for B within three standard errors, 5 %/sqrt(10) each; the velocity is seen
late, so that the paper's reading is 2 % high at the paper's rate and more at higher ones; read back, it is right to
0.5 %.
Source: paper, 4.1 and Figure 4.
"""

from __future__ import annotations

import numpy as np
import typer
from _figures import break_away_figure
from _output import write
from _paper import READINGS, bench, break_away_trial, constants
from _readings import first_seen, read_back

WAYS = {"first_seen": first_seen, "read_back": read_back}


def main(seed: int = 1) -> None:
    """Run the trials and write what they read."""
    rng = np.random.default_rng(seed)
    result, shown = {"seed": seed, "units": {"torque": "N m", "bias": "relative"}}, {}
    for joint in "AB":
        true = float(constants(joint)[:2].sum())
        runs = [break_away_trial(joint, rng) for _ in range(READINGS)]
        found: dict[str, object] = {"true": true}
        for way, read in WAYS.items():
            torques = [read(bench(), run, joint) for run in runs]
            found[way] = {"mean": float(np.mean(torques)), "spread": float(np.std(torques, ddof=1)), "trials": torques}
        for faster in (1, 2, 3):
            even = [break_away_trial(joint, rng, 0.0, faster) for _ in range(READINGS)]
            found[f"bias_at_{faster}_times_the_rate"] = {
                way: float(np.mean([read(bench(), run, joint) for run in even]) / true - 1.0)
                for way, read in WAYS.items()
            }
        result[joint], shown[joint] = found, runs[:4]
    print(f"written to {write('break_away', result, figure_4=break_away_figure(shown, result))}")


if __name__ == "__main__":
    typer.run(main)
