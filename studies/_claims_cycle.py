"""Claims about limit cycles, oscillations and their remedies (4.3.2, 5)."""

from __future__ import annotations

from typing import Any

import numpy as np
from _claims import Claim, judged
from _laws import coth_amplitude, largest_gain
from _single import amplitude, coulomb, mean_error, ramp, regulate, run, stuck_share, threshold

from stribeck.simulate import Compensation, Reference

NOISY = {"sample_time": 0.0125, "encoder_noise": 2e-5, "duration": 200.0}
GAIN = (100.0, 100.0, 10.0)


def cycles() -> dict[str, Any]:
    """Return amplitudes (rad) of regulation with each kind of compensation, over and under."""
    ratios = (0.7, 0.9, 1.0, 1.1, 1.2, 1.3)

    def feedback(ratio: float, at_zero: str = "set_valued", **settings: Any) -> float:
        return amplitude(run("A", regulate(), Compensation("feedback", ratio, at_zero), **settings))  # type: ignore[arg-type]

    cycle, law = {}, {}
    for ratio, zeta in ((1.1, 0.1), (1.3, 0.5), (1.3, 0.9)):
        model = Compensation("feedback", ratio, "set_valued")
        cycle[ratio, zeta] = amplitude(run(coulomb(), regulate(), model, zeta=zeta))
        law[ratio, zeta] = coth_amplitude(ratio, zeta, 30.0, 5.0)
    over = Compensation("feedback", 1.3, "hold")
    return {
        "ratios": ratios,
        "feedforward": [amplitude(run("A", regulate(), Compensation("feedforward", k))) for k in ratios],
        "feedback, zeta 1": [feedback(k, "hold") for k in ratios],
        "feedback, zeta 0.5": [feedback(k, zeta=0.5) for k in ratios],
        "feedback, zeta 1, noise": [feedback(k, "zero", **NOISY) for k in ratios],
        "feedback, PID": [feedback(k, "zero", ki=30.0, duration=200.0) for k in ratios],
        "off_coth_law": max(abs(cycle[case] / law[case] - 1.0) for case in law),
        "rest_at_zeta_1": {"error": mean_error(run("A", regulate(), over)), "law": -0.3 * 6.25 / 30.0},
    }


def thresholds() -> dict[str, Any]:
    """Return the velocity (rad/s) below which joint B sticks and slips at Kp 30: by ratio, and by damping ratio."""
    by_ratio = {ratio: threshold("B", ratio, 1.0) for ratio in (0.0, 0.5, 1.3)}
    return {"by_ratio": by_ratio, "by_zeta": {1.0: by_ratio[0.0], **{z: threshold("B", 0.0, z) for z in (0.5, 0.25)}}}


def remedies() -> dict[str, Any]:
    """Return errors (rad) with adaptive and with robust compensation; the seed of the noise is fixed."""
    sine = Reference("sine", amplitude=0.5, frequency=0.2)
    out: dict[str, Any] = {"adaptive": {}, "robust": {}}
    for ratio in (0.7, 1.3):
        for label, gain in (("fixed", (0.0, 0.0, 0.0)), ("adaptive", GAIN)):
            found = run("A", sine, Compensation("adaptive", ratio, "set_valued", gain=gain), inertia=1.0)
            late = found.error[len(found.error) // 2 :]
            out["adaptive"][f"{label} from k = {ratio}"] = float(np.sqrt(np.mean(late**2)))
    for label, level, sample in (("5 kHz", 1.05, 2e-4), ("5 kHz, too low", 0.9, 2e-4), ("80 Hz", 1.05, 0.0125)):
        found = run("A", regulate(0.1), Compensation("robust", level), sample_time=sample, duration=10.0)
        late = found.error[len(found.error) // 2 :, 0]
        out["robust"][label] = {"error": float(np.abs(late).max()), "moves": float(np.ptp(late))}
    return out


def cycle_claims(c: dict[str, Any], t: dict[str, Any], r: dict[str, Any]) -> list[Claim]:
    """Return the verdicts that follow."""
    over, less = ([k > 1.0 for k in c["ratios"]], [k < 1.0 for k in c["ratios"]])
    cycling = {key: [a > 1e-4 for a in c[key]] for key in c if key.startswith("feed")}
    always = all(flags[i] for flags in cycling.values() for i, up in enumerate(over) if up)
    some = any(flags[i] for flags in cycling.values() for i, up in enumerate(over) if up)
    under = any(flags[i] for flags in cycling.values() for i, low in enumerate(less) if low)
    same = max(t["by_ratio"].values()) / min(t["by_ratio"].values()) - 1.0
    adaptive, robust = r["adaptive"], r["robust"]
    cured = all(adaptive[f"adaptive from k = {k}"] < 0.1 * adaptive[f"fixed from k = {k}"] for k in (0.7, 1.3))
    gains = {delay: largest_gain(delay) for delay in (0, 1, 2)}
    slow = {"stuck_share": {z: stuck_share(run("B", ramp(0.05), zeta=z, duration=40.0)) for z in (1.0, 0.5, 0.25)}}
    over_case = {key: c[key] for key in (*cycling, "off_coth_law", "rest_at_zeta_1")}
    cured = cured and robust["5 kHz"]["error"] < 1e-5
    fold = judged(slow["stuck_share"][1.0] > 0.0, slow["stuck_share"][0.25] > 0.0)
    return [
        Claim("over_compensation", judged(always, some), over_case, "cycles"),
        Claim("under_compensation", judged(not under, under), {"PID": c["feedback, PID"]}, "cycles"),
        Claim("threshold", judged(same > 0.02), {"threshold": t["by_ratio"], "spread": same}, "stick_slip"),
        Claim("oscillations", fold, {"threshold": t["by_zeta"], **slow}, "stick_slip"),
        Claim("remedies", judged(False, cured), r, "remedies"),
        Claim("hardware", judged(gains[0] > gains[1] > gains[2]), {"largest_kp": gains}, "remedies"),
    ]
