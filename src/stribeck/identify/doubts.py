"""What to mind in an identification: each joint, direction and constant that the recordings leave open."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from stribeck.arm import unit_at
from stribeck.identify.findings import Direction, JointFriction
from stribeck.identify.run_fit import RunFit
from stribeck.identify.tustin_fit import NAMES

TAKEN = {
    "runs": "what is taken holds with the fitted masses alone",
    "other direction": "the other direction's constants are taken",
    "nominal": "its friction stays as the arm file has it, beside masses that were fitted with other constants",
}
UNEXPLAINED = 0.1  # share of the break-away torque that the fit to whole runs may leave unremarked


def left_open(joints: Sequence[JointFriction], whole: RunFit) -> list[str]:
    """Return every doubt in words.

    Parameters
    ----------
    joints : sequence of JointFriction
        One a joint of the arm.
    whole : RunFit
    """
    said = []
    if not whole.fit.ok:
        said.append(f"the fit to whole recordings failed ({whole.fit.status}): its values are not used")
    for joint in joints:
        if not joint.directions:
            said.append(f"{joint.name}: it never moved; its friction stays as the arm file has it")
        for way, one in joint.directions.items():
            doubts = [*_of_readings(one), *(_of_runs(one) if whole.fit.ok else ())]
            said += [f"{joint.name}, {way}: {text}" for text in doubts]
    for joint, own, rms in zip(joints, whole.arm.joints, whole.rms, strict=True):
        share = float(rms) / max(own.friction.C0 + own.friction.C1, 1e-12)
        if joint.directions and share > UNEXPLAINED:
            left = f"{rms:.3g} {unit_at('N m', own.kind)} rms of the torque along the recordings"
            what = f"{joint.name}: friction and rigid body leave {left} unexplained"
            said.append(f"{what}, {100.0 * share:.0f} % of its break-away torque; try stribeck diagnose")
    return said + [f"{key}: the recordings want more than three tolerances" for key in whole.fit.at_limit]


def _of_readings(one: Direction) -> Iterator[str]:
    if one.sliding == 0:
        yield "it never slides steadily; only the fit to whole recordings is given"
    elif not one.curve.ok:
        yield f"no curve through {one.curve.points} readings ({one.curve.status.replace('_', ' ')})"
    elif not one.curve.identified.all():
        open_ended = [name for name, sure in zip(NAMES, one.curve.identified, strict=True) if not sure]
        yield f"the readings do not determine {', '.join(open_ended)}"
    elif one.source != "curve":
        yield "a law of the arm file goes with Tustin's friction; the curve through the readings is not taken"


def _of_runs(one: Direction) -> Iterator[str]:
    if one.source != "curve" and not one.runs_identified.all():
        unsure = [name for name, sure in zip(NAMES, one.runs_identified, strict=True) if not sure]
        consequence = f"; {TAKEN[one.source]}" if one.source != "runs" or "C0" in unsure else ""
        yield f"the recordings do not tell {', '.join(unsure)} to half the tolerance{consequence}"
