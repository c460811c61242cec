"""The answer in a few sentences: where, which, how far, and what next. Where the tool abstains, they claim no cause."""

from __future__ import annotations

import math

from stribeck.gap.result import Cause, Diagnosis, Estimate, Place
from stribeck.report import words
from stribeck.report.numbers import number, percent, percent_interval, probability, unit_text, with_unit
from stribeck.report.what_next import what_next

TOLD_FROM = 0.1  # of a joint's gap: less is not worth a sentence
WORSE = 1.1  # of the motion error: more with a named effect than without it is worth a word
NAMED_JOINTS = 3  # joints whose numbers a sentence still carries; more are in the table


def where(diagnosis: Diagnosis) -> str:
    """Return where most of the gap is, and where what is named acts; of an only joint, the stage."""
    places = sorted(diagnosis.where, key=lambda place: -place.share.value)
    if diagnosis.verdict == "no_gap" or not places:
        return (
            "Nowhere beyond the noise: once the nominal values are re-tuned, as far as their tolerances allow, "
            f"what is left on the {words.held(diagnosis)} cannot be told from noise."
            f"{_before_measurement(diagnosis)}"
        )
    several = len(diagnosis.joints) > 1
    gap = "the gap that re-tuning leaves" + (" (each joint measured by its own noise) lies" if several else " is")
    first = f"{percent_interval(places[0].share)} of {gap} {_place(diagnosis, places[0])}"
    if len(places) == 1 and not several:
        first = f"{gap.capitalize()} {_place(diagnosis, places[0])}"
    said = {(place.joint, place.channel) for place in places[:2]} | {(place.joint, "unknown") for place in places}
    named = [place for place in places[2:] if diagnosis.named and (place.joint, place.channel) not in said]
    shares = [f"{percent_interval(place.share)} {_place(diagnosis, place)}" for place in (*places[1:2], *named)]
    further = f"; next, {'; '.join(shares)}" if shares else ""
    return f"{first}{further}.{_before_measurement(diagnosis)}"


def _before_measurement(diagnosis: Diagnosis) -> str:
    """Return what of the gap the measured torque already shows, where it shows some; a sentence, or nothing."""
    shares = [(row.share, words.joints([row.joint])) for row in diagnosis.delivered]
    said = [f"{percent_interval(share)} at {joint}" for share, joint in shares if share and _told(share)]
    if said:
        who = (
            f"the actuator accounts for at least {words.listing(said)} of what re-tuning leaves, gain and offset apart"
        )
    elif diagnosis.before_measurement and _told(diagnosis.before_measurement):
        least = percent_interval(diagnosis.before_measurement)
        who = f"actuators account for at least {least} of what re-tuning leaves in all, gain and offset apart"
    else:
        return ""
    return f" By the measured {words.effort(diagnosis)}, {who}."


def _told(share: Estimate) -> bool:
    return share.low > 0.0 and share.value > TOLD_FROM


def finding(diagnosis: Diagnosis) -> str:
    """Return where most of the gap lies as the title of a figure: the joint, and the region where it is densest.

    A region that holds no more than its part of the time is none that one would look at.
    """
    shares = share_of_joints(diagnosis)
    most = max(shares, key=lambda name: shares[name])
    top = max((place for place in diagnosis.where if place.joint == most), key=lambda place: place.share.value)
    joint, whole = words.short(most), shares[most]
    head = f"{joint} holds {percent(whole)} of the gap" if len(diagnosis.joints) > 1 else f"{joint}: the gap"
    region = next((r for r in diagnosis.regions if (r.joint, r.region) == (top.joint, top.region)), None)
    if region is None:
        return f"{head}{',' if len(diagnosis.joints) > 1 else ' is'} densest {words.region(top.region)}"
    if not region.share.low > region.time_share:
        return f"{head}{', spread' if len(diagnosis.joints) > 1 else ' is spread'} over its motion"
    if len(diagnosis.joints) > 1:
        return f"{head}; {percent(region.share.value)} of that lies {words.region(top.region)}"
    return f"{joint}: {percent(region.share.value)} of the gap lies {words.region(top.region)}"


def share_of_joints(diagnosis: Diagnosis) -> dict[str, float]:
    """Return the part of the gap that each joint holds, of those that hold any."""
    shares: dict[str, float] = {}
    for place in diagnosis.where:
        shares[place.joint] = shares.get(place.joint, 0.0) + place.share.value
    return {joint: min(share, 1.0) for joint, share in shares.items()}


def which(diagnosis: Diagnosis) -> str:
    """Return the named effects with their probability and those that cannot be told from them."""
    if diagnosis.verdict == "no_gap":
        chance = words.probability_of(diagnosis, "none")
        return f"No unmodelled effect is named: none is needed{_chance(chance, 'that there is none')}."
    if not diagnosis.named:
        chance = words.probability_of(diagnosis, "unknown")
        return (
            f"No cause is named: no known effect explains the gap{_chance(chance, 'that the cause is none of them')}."
        )
    *before, last = (claim(diagnosis, words.cause_of(diagnosis, name)) for name in diagnosis.named)
    claims = f"{'; '.join(before)}; and {last}" if before else last
    claims = f"{claims[0].upper()}{claims[1:]}."
    if diagnosis.verdict == "explained":
        return claims
    return f"{claims} This explains a part only; for the rest no cause is named."


def claim(diagnosis: Diagnosis, cause: Cause) -> str:
    """Return one cause as it may be claimed: "presliding or backlash at joint A (97 %): these data cannot tell"."""
    names = [words.effect(name) for name in dict.fromkeys((cause.effect, *cause.equivalent))]
    place = f"at {words.joints(cause.joints)}"
    if cause.anywhere:
        place = f"at {words.joints(cause.joints, 'or')}, or at {'both' if len(cause.joints) == 2 else 'several'}"
    chance = words.class_probability(diagnosis, cause)
    if len(names) == 1:
        return f"{names[0]} {place}{_chance(chance, 'that it is there')}"
    together = f" ({probability(chance)} together)" if math.isfinite(chance) else ""
    return f"{words.listing(names, 'or')} {place}{together}: these data cannot tell which"


def how_far(diagnosis: Diagnosis) -> str:
    """Return how much of the gap closes on held-out runs, with the rms of torque and motion per joint."""
    rms = _rms(diagnosis) + _motion(diagnosis)
    random = _random(diagnosis)
    if diagnosis.verdict == "no_gap":
        return f"Re-tuning alone reaches the noise. {rms}{random}"
    if not diagnosis.named:
        return f"No effect was added, so the gap stays as re-tuning leaves it. {rms}{random}"
    if words.in_records_alone(diagnosis):
        return f"Re-tuning alone reaches the noise: what is named shows in the records themselves. {rms}{random}"
    if diagnosis.closed is None:
        return f"No part of a {words.effort(diagnosis)} gap counts as closed. {rms}{random}"
    what = "it closes" if len(diagnosis.named) == 1 else "together they close"
    part = f"{percent_interval(diagnosis.closed)} of the {words.effort(diagnosis)} gap"
    return f"Added to the model, {what} {part} above the noise floor, on {words.unfitted(diagnosis)}. {rms}{random}"


def _random(diagnosis: Diagnosis) -> str:
    """Return what of the noise floor is random torque, where some is; a sentence, or nothing."""
    said = [
        f"{number(row.rms)} {unit_text(row.unit)} at {words.joints([row.joint])} (below {number(row.bandwidth)} Hz)"
        for row in diagnosis.random
    ]
    if not said:
        return ""
    return (
        f" Part of the floor is random {words.effort(diagnosis)}, which knows nothing of the motion: "
        f"{words.listing(said)}. No model of the arm can follow it."
    )


def answers(diagnosis: Diagnosis) -> tuple[tuple[str, str], ...]:
    """Return (question, sentence) for the first screen."""
    return (
        ("Where", where(diagnosis)),
        ("Which", which(diagnosis)),
        ("How far", how_far(diagnosis)),
        ("Next", what_next(diagnosis)),
    )


def _rms(diagnosis: Diagnosis) -> str:
    stages = {stage.stage: stage.torque for stage in diagnosis.stages}
    last = words.last_stage(diagnosis)
    if not {"as_given", "retuned", last} <= set(stages):
        return ""
    unit = unit_text(words.torque_unit(diagnosis))
    path = list(dict.fromkeys(("as_given", "retuned", last)))
    parts = []
    for joint in diagnosis.joints[:NAMED_JOINTS]:
        text = " → ".join(number(stages[name].get(joint, math.nan)) for name in path)
        floor = stages.get("noise_floor", {}).get(joint, math.nan)
        text += f" {unit}" + (f" (floor {number(floor)})" if math.isfinite(floor) else "")
        parts.append(f"{words.short(joint)} {text}")
    more = len(diagnosis.joints) - NAMED_JOINTS
    tail = f"; {more} more in the table below" if more > 0 else ""
    legend = " → ".join(("as given", "re-tuned", words.final(diagnosis))[: len(path)])
    return f"{words.effort(diagnosis).capitalize()} rms, {legend}: {'; '.join(parts)}{tail}."


def _motion(diagnosis: Diagnosis) -> str:
    """Return what is left of the simulated motion, re-tuned and with what is named; a sentence, or nothing."""
    stages = {stage.stage: stage.motion for stage in diagnosis.stages}
    path = list(dict.fromkeys(("retuned", words.last_stage(diagnosis))))
    known = [j for j in diagnosis.joints if all(math.isfinite(stages.get(name, {}).get(j, math.nan)) for name in path)]
    if not known:
        return ""
    values = {joint: [stages[name][joint] for name in path] for joint in known}
    unit, horizon = unit_text(words.position_unit(diagnosis)), with_unit(diagnosis.horizon, "s", 2)
    parts = [f"{words.short(j)} {' → '.join(map(number, values[j]))} {unit}" for j in known[:NAMED_JOINTS]]
    worse = [joint for joint in known if values[joint][-1] > WORSE * values[joint][0]]
    legend = " → ".join(("re-tuned", words.final(diagnosis))[: len(path)])
    grows = f"; at {words.joints(worse)} it is worse for what is named" if worse else ""
    return f" Motion, simulated for {horizon}, {legend}: {'; '.join(parts)}{grows}."


def _place(diagnosis: Diagnosis, place: Place) -> str:
    """Return joint, possible stages and densest region; where nothing is named a stage is a likeness, not a claim.

    An only joint goes without saying.
    """
    possible = place.channels or (place.channel,)
    name = words.listing([words.clean(channel).replace("_", " ") for channel in possible], "or")
    if name in ("", "unknown", "none"):
        stage = "of unknown origin" if diagnosis.named else ""
    else:
        stage = f"in the {name} stage" if diagnosis.named else f"most like the {name} stage"
    at = f"at {words.joints([place.joint])}" if len(diagnosis.joints) > 1 else ""
    return ", ".join(part for part in (at, stage, f"densest {words.region(place.region)}") if part)


def _chance(value: float, what: str) -> str:
    if not (math.isfinite(value) and value > 0):
        return ""
    return f" (probability {probability(value)} {what})"
