"""Question: what does feedforward compensation change (4.3, Figures 8 to 10)? The error by one factor, at any gain.

Method: the two-link bench at 80 Hz, Kv = 2 sqrt(Kp) as in the paper, velocity by finite difference, encoder noise 20
urad, the other joint under PID; joint A at both velocities, B at the lower one; without compensation, with a model 10
% low ("an utmost precision of about 90 %") and with the exact one.
Expected: without compensation the steady error is F(v)/Kp, 191.7 mrad at most (A, Kp 30, 0.5 rad/s); with k of
friction compensated it is (1 - k) F(v)/Kp at either velocity and gain: the share that is left depends on neither, so
that the paper's "more pronounced at low velocity" is not in the steady error. At the start from rest a lower velocity
takes longer to break away without compensation: there it is.
Source: paper, 4.3, equations (13) and (14).
"""

from __future__ import annotations

import numpy as np
import typer
from _compensation_figures import error_figure
from _output import write
from _paper import NOISE, SAMPLE, STIFF, bench, constants

from stribeck.identify.tustin_fit import tustin
from stribeck.simulate import Closed, Compensation, JointLoop, Loop, Reference, close_loop

FIGURES = {"figure_8": ("A", 0.5, 4.0), "figure_9": ("A", 0.05, 12.0), "figure_10": ("B", 0.05, 12.0)}
RATIOS = {"none": 0.0, "90 %": 0.9, "exact": 1.0}


def run(joint: str, velocity: float, duration: float, kp: float, ratio: float) -> Closed:
    """Simulate one of the paper's runs."""
    kind = Compensation("feedforward", ratio) if ratio else Compensation()
    ramp = Reference("ramp", velocity=velocity)
    moving = JointLoop(joint, kp, ramp, kv=2.0 * kp**0.5, encoder_noise=NOISE, compensation=kind)
    held = JointLoop("B" if joint == "A" else "A", STIFF, Reference("regulate"), ki=200.0, encoder_noise=NOISE)
    return close_loop(bench(), Loop(SAMPLE, duration, (moving, held), seed=1))


def main() -> None:
    """Run all, compare with the law, write the figures."""
    result, figures, worst = {"units": {"error": "rad", "rms_of_first": "rad, over the first second"}}, {}, 0.0
    for name, (joint, velocity, duration) in FIGURES.items():
        j, rows, shown = "AB".index(joint), [], {}
        friction = float(tustin(constants(joint), np.array([velocity]))[0])
        for kp in (60.0, 30.0):
            for label, ratio in RATIOS.items():
                found = shown[kp, label] = run(joint, velocity, duration, kp, ratio)
                error, count = found.error[:, j], len(found.error)
                steady, law = float(error[count // 2 :].mean()), (1.0 - ratio) * friction / kp
                worst = max(worst, abs(steady - law) * kp / friction)
                first = float(np.sqrt(np.mean(error[: round(1.0 / SAMPLE)] ** 2)))
                peak = float(np.abs(error).max())
                rows.append(
                    {"kp": kp, "model": label, "error": steady, "law": law, "peak": peak, "rms_of_first": first}
                )
        result[name] = {"joint": joint, "velocity": velocity, "runs": rows}
        figures[name] = error_figure(shown, j, f"Joint {joint} at {velocity:g} rad/s")
    result["worst_departure_from_the_law"] = {"of F(v)/Kp": worst}
    print(f"written to {write('compensation', result, **figures)}")


if __name__ == "__main__":
    typer.run(main)
