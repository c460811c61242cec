"""Claims about position error: compensation, gains, velocity, precision (4.3, 5, 6)."""

from __future__ import annotations

from typing import Any

import numpy as np
from _claims import Claim, close, judged
from _paper import constants
from _single import mean_error, ramp, run

from stribeck.identify.tustin_fit import tustin
from stribeck.simulate import Compensation

RATIOS = (0.0, 0.7, 0.9, 1.0, 1.1, 1.3)
EARLIER = {  # mrad, without compensation
    ("A", 30.0, 0.5): 191.7, ("A", 30.0, 0.05): 184.5, ("A", 60.0, 0.5): 95.8, ("A", 60.0, 0.05): 92.3,
    ("B", 30.0, 0.5): 86.7, ("B", 30.0, 0.05): 80.4, ("B", 60.0, 0.5): 43.3, ("B", 60.0, 0.05): 40.2,
}  # fmt: skip


def ramps() -> list[dict[str, Any]]:
    """Return steady and peak errors of every joint, gain, velocity and ratio, rad."""
    rows = []
    for joint, kp, velocity in EARLIER:
        for ratio in RATIOS:
            model = Compensation("feedforward", ratio) if ratio else Compensation()
            found = run(joint, ramp(velocity), model, kp=kp, duration=40.0 if velocity < 0.1 else 12.0)
            law = (1.0 - ratio) * float(tustin(constants(joint), np.array([velocity]))[0]) / kp
            rows.append({"joint": joint, "kp": kp, "velocity": velocity, "ratio": ratio, "error": mean_error(found),
                         "law": law, "peak": float(np.abs(found.error).max())})  # fmt: skip
    return rows


def error_claims(rows: list[dict[str, Any]]) -> list[Claim]:
    """Return the verdicts that follow from the ramps."""

    def of(key: str, kp: float, velocity: float, ratio: float, joint: str = "A") -> float:
        case = {"joint": joint, "kp": kp, "velocity": velocity, "ratio": ratio}
        return float(next(row[key] for row in rows if case.items() <= row.items()))

    plain = {case: 1e3 * of("error", case[1], case[2], 0.0, case[0]) for case in EARLIER}
    table = max(abs(plain[case] / value - 1.0) for case, value in EARLIER.items())
    law = max(abs(row["error"] - row["law"]) for row in rows)
    smaller = all(
        abs(row["error"]) < of("error", row["kp"], row["velocity"], 0.0, row["joint"]) for row in rows if row["ratio"]
    )
    speeds, gains = (0.5, 0.05), (30.0, 60.0)
    left = {v: of("error", 30.0, v, 0.9) / of("error", 30.0, v, 0.0) for v in speeds}
    left_of_peak = {v: of("peak", 30.0, v, 0.9) / of("peak", 30.0, v, 0.0) for v in speeds}
    benefit = {v: 1e3 * (of("error", 30.0, v, 0.0) - of("error", 30.0, v, 0.9)) for v in speeds}
    by_gain = {kp: 1e3 * (of("error", kp, 0.05, 0.0) - of("error", kp, 0.05, 0.9)) for kp in gains}
    rest = {kp: 1e3 * of("error", kp, 0.05, 0.9) for kp in gains}
    off = {ratio: 1e3 * of("error", 30.0, 0.05, ratio) for ratio in (0.9, 1.0, 1.1)}
    slow = {"share_left": left, "share_left_of_the_peak": left_of_peak, "benefit_mrad": benefit}
    listed = {" ".join(map(str, case)): value for case, value in plain.items()}
    always_slow = benefit[0.05] > benefit[0.5] and left[0.05] < left[0.5] - 1e-3
    costs = close(off[0.9], 0.1 * plain["A", 30.0, 0.05], 0.01) and abs(off[1.0]) < 0.01
    return [
        Claim("not_immune", judged(min(plain.values()) > 10.0), {"errors_mrad": listed, "off_table": table}, "errors"),
        Claim("smaller_error", judged(False, smaller), {"off_law_rad": law}, "errors"),
        Claim("low_velocity", judged(always_slow, left_of_peak[0.05] < left_of_peak[0.5]), slow, "errors"),
        Claim("large_gains", judged(False, close(by_gain[30.0], 2 * by_gain[60.0], 0.01)), {"mrad": by_gain}, "errors"),
        Claim("better_at_large_gains", judged(False, rest[60.0] < rest[30.0]), {"left_mrad": rest}, "errors"),
        Claim("precision", judged(costs), {"error_mrad": off}, "errors"),
    ]
