"""Cycles in words: verdicts, sizes, methods."""

from __future__ import annotations

from stribeck.arm import unit_at
from stribeck.loop.answers import JointAnswer
from stribeck.loop.exact.turns import TINY
from stribeck.loop.ripple import DITHER, GRAVITY
from stribeck.report import words
from stribeck.report.numbers import NBSP, NOTHING, milli, number, percent, unit_text, with_unit

VERDICT = {
    "rest": "Comes to rest",
    "steady": "Slides steadily",  # what is called rest, along a ramp
    "ripple": "Forced ripple",  # what is called a sliding cycle, where the arm's waves set its period
    "forced": "Forced motion",  # what is called any cycle, where a dither sets its period
    "stick_slip": "Stick-slip",
    "hunting": "Hunting",
    "sliding_cycle": "Sliding cycle",
    "chatter": "Chatter",
    "unbounded": "Unbounded",
    "undetermined": "Undetermined",
}
METHOD = {
    "describing_function": "describing function",
    "harmonic_balance": "harmonic balance",
    "shooting": "shooting",
    "simulation": "simulation",
}


def rotation(answer: JointAnswer, value: float, digits: int = 3) -> str:
    """Return a position in mrad, or mm for a prismatic axis."""
    return f"{milli(value, digits)}{NBSP}{small_unit(answer)}"


def small_unit(answer: JointAnswer) -> str:
    """Return mrad or mm."""
    return unit_at("mrad", answer.kind)


def speed_unit(answer: JointAnswer) -> str:
    """Return rad/s or m/s."""
    return unit_at("rad/s", answer.kind)


def gain_unit(answer: JointAnswer) -> str:
    """Return N m/rad or N/m."""
    return unit_at("N m/rad", answer.kind)


def seconds(value: float) -> str:
    """Return a time."""
    return with_unit(value, "s")


def on_a_ramp(answer: JointAnswer) -> bool:
    """Tell whether the reference moves on for ever: there what is called rest is steady sliding."""
    return answer.entry.reference.kind == "ramp" and answer.entry.reference.velocity != 0.0


def reads_as(answer: JointAnswer, verdict: str | None = None) -> str:
    """Return the key of `VERDICT` under which a person reads a verdict, the joint's own where none is given."""
    verdict = answer.cycle.verdict if verdict is None else verdict
    if answer.forced is not None and answer.forced.explains(verdict):
        return "forced" if answer.forced.cause == DITHER else "ripple"
    return "steady" if verdict == "rest" and on_a_ramp(answer) else verdict


def when_forced(answer: JointAnswer) -> str:
    """Return what a joint does that something forces on it, as a legend names it."""
    return "forced motion" if any(each.cause == DITHER for each in answer.passages) else "forced ripple"


def at_rest(answer: JointAnswer) -> str:
    """Return what a joint does that does not cycle, as a legend names it."""
    return "steady sliding" if on_a_ramp(answer) else "rest"


def steady_error(answer: JointAnswer) -> float | None:
    """Return the error at rest, rad; 0 where it is less than any motion that the methods count."""
    error = answer.cycle.steady_error
    return 0.0 if error is not None and abs(error) < TINY else error


def headline(answer: JointAnswer) -> str:
    """Return the verdict on one joint in one line, for the terminal and for figures."""
    return f"{words.short(answer.joint)}: {_finding(answer)}"


def _finding(answer: JointAnswer) -> str:
    cycle = answer.cycle
    verdict = VERDICT[reads_as(answer)].lower()
    if cycle.cycles and cycle.amplitude is not None and cycle.period is not None:
        stuck = f", stuck {percent(cycle.stick_fraction)} of the time" if cycle.stick_fraction else ""
        return (
            f"{verdict} of ±{rotation(answer, cycle.amplitude)} every {seconds(cycle.period)}{stuck}{_forced(answer)}"
        )
    if cycle.verdict == "rest" and (error := steady_error(answer)) is not None:
        return _steady(answer, error)
    return verdict + (f" ({cycle.status})" if cycle.status != "ok" else "")


def _forced(answer: JointAnswer) -> str:
    """Return what forces a motion, as the end of a sentence; nothing of a cycle of the loop's own."""
    wave = answer.forced
    if wave is None:
        return ""
    whose = "its" if wave.joint == answer.joint else f"{words.short(wave.joint)}'s"
    if wave.cause == DITHER:
        return f", forced by {whose} dither"
    passed = "makes a turn under gravity" if wave.cause == GRAVITY else f"passes a wave of {words.effect(wave.cause)}"
    return f", in which {whose} ramp {passed}"


def _steady(answer: JointAnswer, error: float) -> str:
    if on_a_ramp(answer):
        return f"slides steadily along its ramp, {along_ramp(answer, error)}"
    away = f"{rotation(answer, abs(error))} from" if abs(error) > NOTHING else "at"
    return f"comes to rest {away} its reference"


def along_ramp(answer: JointAnswer, error: float) -> str:
    """Return how far behind its ramp a joint is, or ahead of it."""
    if abs(error) <= NOTHING:
        return "on it"
    side = "behind" if error * answer.entry.reference.velocity > 0.0 else "ahead of"
    return f"{rotation(answer, abs(error))} {side} it"


def answer_sentences(answer: JointAnswer, several: bool) -> tuple[tuple[str, str], ...]:
    """Return (question, sentence) pairs for the first screen; the joint's name leads where there are several."""
    method = answer.methods["describing_function"]
    trust = "can be trusted here" if method.trusted else "cannot be trusted here"
    if method.status == "not_applicable":
        trust = "does not apply here"
    head = f"{words.short(answer.joint)}: " if several else ""
    found = _finding(answer)
    return (
        (f"{head}what", f"{found[0].upper()}{found[1:]}."),
        (f"{head}limits", f"{_limits(answer)}."),
        (f"{head}method", f"The describing function {trust}: {method.why}."),
    )


def _limits(answer: JointAnswer) -> str:
    gain, unit = answer.kp_max, unit_text(gain_unit(answer))
    parts = []
    if gain.stability is not None:
        robust = "" if gain.ms2 is None else f", with a sensitivity peak of at most 2 up to {number(gain.ms2)}"
        stable = f"the linear loop is stable up to {number(gain.stability)}{robust}"
        parts.append(f"Kp is {number(answer.kp)}{NBSP}{unit}; {stable}")
    else:
        parts.append(f"Kp is {number(answer.kp)}{NBSP}{unit}; {gain.why}")
    if answer.k_critical == 0.0:
        does = "grows without bound" if answer.cycle.verdict == "unbounded" else "cycles"
        parts.append(f"it {does} without compensation{'' if answer.cycle.verdict == 'rest' else ' too'}")
    elif answer.k_critical is not None:
        parts.append(f"cycles begin at k = {number(answer.k_critical, 4)}")
    if answer.fold_velocity is not None:
        parts.append(f"it sticks and slips on ramps slower than {with_unit(answer.fold_velocity, speed_unit(answer))}")
    return "; ".join(parts)
