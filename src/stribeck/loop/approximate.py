"""The approximate answers for one joint, and whether they can be trusted beside the exact one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from stribeck.arm import Arm, Friction
from stribeck.effects.placing import placed_effects, vanishes
from stribeck.loop.answers import Method, Nyquist
from stribeck.loop.cycle import WORDS, Cycle
from stribeck.loop.describing import (
    Compensator,
    Harmonics,
    LinearPart,
    Root,
    describing_function,
    find_roots,
    harmonic_balance,
    linear_part,
    symmetric,
)
from stribeck.loop.describing.roots import compensation
from stribeck.loop.linear.bends import bends
from stribeck.model.effect import FrictionEffect
from stribeck.simulate.loop import JointLoop, Loop

Floats = NDArray[np.float64]

MOST_DAMPING = 0.3  # up to here one harmonic is within 3 % in amplitude and 5 % in period of an exact Coulomb cycle
MOST_ERROR = 0.05
HARMONICS = 20
POINTS, MOST_POINTS, PHASE = 2000, 8000, 0.008  # of the curve shown; and the phase, rad, between two with a long delay
SLOWEST, FASTEST = 2e-3, 30.0  # of the frequencies shown, relative to sqrt(Kp/J)


@dataclass(frozen=True)
class Approximation:
    """Both approximate methods, and what the first one is read from."""

    describing_function: Method
    harmonic_balance: Method
    nyquist: Nyquist | None


@dataclass(frozen=True)
class _Case:
    arm: Arm
    entry: JointLoop
    part: LinearPart
    friction: Friction
    compensator: Compensator


def approximate(arm: Arm, loop: Loop, joint: str, exact: Cycle, damping: float) -> Approximation:
    """Return what describing function and harmonic balance say of one joint, the others held.

    Parameters
    ----------
    arm : Arm
    loop : Loop
        Checked.
    joint : str
    exact : Cycle
        The answer to compare with.
    damping : float
        Smallest damping ratio of the joint's linear loop.
    """
    why = not_applicable(loop, joint)
    if why:
        none = Method("not_applicable", None, False, why)
        return Approximation(none, none, None)
    case = _case(arm, loop, joint)
    if case.friction.C0 + case.friction.C1 == 0.0:
        none = Method("not_applicable", None, False, "the joint has no dry friction")
        return Approximation(none, none, None)
    roots = find_roots(case.part, case.friction, case.compensator)
    first = _describing_method(case, roots, exact, damping)
    return Approximation(first, _balance_method(case, roots, exact), _nyquist(case, roots))


def predicted_amplitudes(arm: Arm, loops: Sequence[Loop], joint: str) -> Floats:
    """Return the describing function's amplitude (K,), rad, in each of K loops; nan where it predicts no cycle."""
    found = np.full(len(loops), np.nan)
    for i, loop in enumerate(loops):
        if not_applicable(loop, joint):
            continue
        case = _case(arm, loop, joint)
        root = _chosen(find_roots(case.part, case.friction, case.compensator))
        found[i] = np.nan if root is None else root.amplitude
    return found


def not_applicable(loop: Loop, joint: str) -> str:
    """Return why a describing function says nothing of a joint's loop; "" where it does."""
    entry = _entry(loop, joint)
    if entry.compensation.kind in ("adaptive", "robust", "dither"):
        return f"no describing function of the {entry.compensation.kind} law"
    if entry.reference.kind == "ramp" and entry.reference.velocity != 0.0:
        return "stick-slip along a ramp is one-sided: no sinusoid about rest"
    return ""


def _entry(loop: Loop, joint: str) -> JointLoop:
    return next(entry for entry in loop.joints if entry.joint == joint)


def _case(arm: Arm, loop: Loop, joint: str) -> _Case:
    j = arm.names.index(joint)
    friction = symmetric(arm.joints[j].friction, arm.joints[j].backward)
    entry = _entry(loop, joint)
    part = linear_part(arm, loop, joint)
    return _Case(arm, entry, part, friction, Compensator.of(entry.compensation, friction))


def _chosen(roots: tuple[Root, ...]) -> Root | None:
    """Return the largest stable sinusoid: the one that a motion from far out settles on."""
    stable = [root for root in roots if root.stable]
    return max(stable, key=lambda root: root.amplitude) if stable else None


def _describing_method(case: _Case, roots: tuple[Root, ...], exact: Cycle, damping: float) -> Method:
    root = _chosen(roots)
    doubts = _doubts(case, exact) + ([f"damping ratio {damping:.2g}"] if root and damping > MOST_DAMPING else [])
    if root is None:
        return _none_found("ok", doubts, exact)
    answer = Method("ok", True, False, "", root.amplitude, root.period, stable=True)
    return _judged(answer, doubts, exact)


def _balance_method(case: _Case, roots: tuple[Root, ...], exact: Cycle) -> Method:
    root, doubts = _chosen(roots), _doubts(case, exact)
    if case.compensator.dead_band > 0.0:
        return Method("not_applicable", None, False, "no harmonic balance with a dead-band")
    if root is None:
        return _none_found("ok", doubts, exact)
    found = harmonic_balance(case.part, case.friction, case.compensator, root, HARMONICS)
    if found.status == "sticks":
        return _none_found("sticks", ["what balances would change direction where it must stick", *doubts], exact)
    if found.status != "ok":
        return Method(found.status, None, False, "Newton's method found no balance of all harmonics")
    return _judged(_answer(found), doubts + _few(found), exact)


def _none_found(status: str, doubts: list[str], exact: Cycle) -> Method:
    """Return the answer of a method that finds no cycle."""
    if exact.verdict == "undetermined":
        return Method(status, False, False, "; ".join([*doubts, "no exact answer to compare with"]))
    if exact.cycles:
        missed = f"predicts no cycle where there is {WORDS.get(exact.verdict, exact.verdict)}"
        return Method(status, False, False, "; ".join([missed, *doubts]))
    none = "predicts no cycle, and there is none"
    none += ": the motion grows without bound" if exact.verdict == "unbounded" else ""
    return Method(status, False, not doubts, "; ".join(doubts) or none)


def _answer(found: Harmonics) -> Method:
    return Method("ok", True, False, "", found.amplitude, found.period)


def _few(found: Harmonics) -> list[str]:
    count = len(found.order)
    return [f"only {count} harmonics lie below the Nyquist frequency"] if count < 5 else []


def _doubts(case: _Case, exact: Cycle) -> list[str]:
    """Return the reasons for which a sinusoid does not describe this joint's motion."""
    j = case.arm.names.index(case.entry.joint)
    placed = [p for p in placed_effects(case.arm) if j in p.joints(case.arm.n) and not vanishes(p)]
    laws = sorted({p.effect.name for p in placed if isinstance(p.effect, FrictionEffect)})
    doubts = [f"leaves out the effect {name}" for name in laws]
    doubts += [f"takes the effect {name} for linear" for name in sorted({p.effect.name for p in placed if bends(p)})]
    if exact.stick_fraction:
        doubts.append(f"the joint sticks for {100.0 * exact.stick_fraction:.3g} % of the cycle")
    if case.entry.ki > 0.0:
        sticks = exact.stick_fraction or exact.verdict == "undetermined"
        doubts.append(f"the integral {'winds up while' if sticks else 'would wind up where'} the joint sticks")
    if case.entry.encoder_noise > 0.0 or case.entry.encoder_resolution > 0.0:
        doubts.append("leaves out the encoder's noise and resolution")
    return doubts


def _judged(answer: Method, doubts: list[str], exact: Cycle) -> Method:
    """Return an answer with its errors against the exact cycle, and what follows for its trust."""
    if exact.verdict == "undetermined":
        return replace(answer, why="; ".join([*doubts, "no exact answer to compare with"]))
    if not exact.cycles or exact.amplitude is None or exact.period is None:
        return replace(answer, why="; ".join([f"predicts a cycle where the exact answer is {exact.verdict}", *doubts]))
    assert answer.amplitude is not None
    assert answer.period is not None
    errors = (answer.amplitude / exact.amplitude - 1.0, answer.period / exact.period - 1.0)
    if max(map(abs, errors)) > MOST_ERROR:
        doubts = [*doubts, f"off by {100.0 * errors[0]:+.3g} % in amplitude and {100.0 * errors[1]:+.3g} % in period"]
    why = "; ".join(doubts) or f"within {100.0 * MOST_ERROR:g} % of the exact cycle"
    return replace(answer, trusted=not doubts, why=why, amplitude_error=errors[0], period_error=errors[1])


def _nyquist(case: _Case, roots: tuple[Root, ...]) -> Nyquist:
    """Return the curves whose intersections are the roots: W with the compensation's share, and -1/N.

    The share is that at the chosen root's amplitude, on which it hardly depends.
    """
    part, root = case.part, _chosen(roots)
    top = min(FASTEST * part.own_frequency, 0.999 * part.highest)
    low, late = SLOWEST * part.own_frequency, part.delay + part.entry.delay_samples * part.sample_time
    if late > 0.0:  # every turn of the delay's phase wants its points, up to where nobody can see them
        top = min(top, MOST_POINTS * PHASE / late)
    omega = np.geomspace(low, top, POINTS)
    if late > 0.0:
        omega = np.union1d(omega, np.arange(low, top, PHASE / late))
    scale = max(case.friction.C0 + case.friction.C1, 1e-9) / max(part.kv, 1e-9)
    speed = np.geomspace(1e-3 * scale, 1e3 * scale, 400)
    reference = root.velocity if root is not None else scale
    own = float(describing_function(np.array(reference), case.friction))
    share = compensation(part, case.compensator, np.array(reference), omega) / own if own > 0.0 else 0.0
    inverse = np.asarray(-1.0 / describing_function(speed, case.friction), dtype=complex)
    return Nyquist(omega, np.asarray(part.response(omega) * (1.0 - share)), speed, inverse, roots)
