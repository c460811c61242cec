"""The tables of the limit-cycle page."""

from __future__ import annotations

from stribeck.arm import unit_at
from stribeck.loop.answers import Analysis, JointAnswer, Method
from stribeck.loop.linear import KpMax
from stribeck.report import words
from stribeck.report.cycle_words import METHOD, VERDICT, gain_unit, reads_as, small_unit, speed_unit, steady_error
from stribeck.report.numbers import MINUS, NBSP, milli, number, percent, unit_text, with_unit
from stribeck.report.page import Facts, Row, Table

_DASH = "–"


def verdict_table(analysis: Analysis) -> Table:
    """Return what each joint ends in."""
    rows = []
    for answer in analysis.joints:
        cycle = answer.cycle
        rows.append(
            Row(
                (
                    words.clean(answer.joint), VERDICT[reads_as(answer)].lower(), _milli(cycle.amplitude),
                    _value(cycle.period), _value(cycle.peak_velocity),
                    _DASH if cycle.stick_fraction is None else percent(cycle.stick_fraction),
                    _milli(steady_error(answer)), _multiplier(answer), _stable(cycle.stable),
                )
            )
        )  # fmt: skip
    unit, speed = small_unit(analysis.joints[0]), speed_unit(analysis.joints[0])
    columns = (
        "joint", "ends in", f"amplitude, {unit}", "period, s", f"peak velocity, {speed}", "stuck",
        f"steady error, {unit}", "largest multiplier", "stable",
    )  # fmt: skip
    note = (
        "The amplitude is half the peak-to-peak position. Multipliers are the eigenvalues of the return map: a small "
        "disturbance of the cycle is multiplied by them every period. Those of a sampled loop are of the samples after "
        "which it repeats, a round's share of them; without such, mean growth a round along its motion."
    )
    return Table("What the loop does", columns, tuple(rows), frozenset({2, 3, 4, 5, 6, 7}), note)


def method_table(answer: JointAnswer) -> Table:
    """Return all methods side by side for one joint."""
    rows = []
    for name, method in answer.methods.items():
        mark = "strong" if name == "shooting" else "flag" if not method.trusted else ""
        rows.append(
            Row(
                (METHOD[name], _finds(method, answer), *_numbers(method), _trust(method), words.clean(method.why)), mark
            )
        )
    unit = small_unit(answer)
    columns = ("method", "cycle", f"amplitude, {unit}", "error", "period, s", "error", "trusted", "why")
    note = (
        "Errors are against the exact cycle. A describing function knows no sticking; it is trusted up to a damping "
        "ratio of 0.3, without sticking and integral action, where the exact answer confirms it."
    )
    title = f"Joint {words.clean(answer.joint)}: all methods side by side"
    return Table(title, columns, tuple(rows), frozenset({2, 3, 4, 5}), note)


def gain_facts(answer: JointAnswer) -> Facts:
    """Return gains, margins and limits of one joint."""
    gain, m, top = unit_text(gain_unit(answer)), answer.margins, answer.kp_max
    damping = unit_at("N m s/rad", answer.kind)
    pairs = [
        ("gains", f"Kp {number(answer.kp)}{NBSP}{gain}, Kv {with_unit(answer.kv, damping)}, k {number(answer.ratio)}"),
        ("largest Kp", _largest(top, gain)),
        ("linear loop", "stable" if m.stable else "unstable"),
    ]
    if m.stable:
        pairs += [
            ("sensitivity peak Ms", number(m.sensitivity_peak)),
            ("gain and phase margin", f"{number(m.gain_margin)} and {with_unit(m.phase_margin, 'rad')}"),
            ("delay margin", with_unit(1e3 * m.delay_margin, "ms")),
            ("bandwidth", with_unit(m.bandwidth, "rad/s")),
            ("smallest damping ratio, of the whole loop", number(m.damping)),
        ]
    pairs.append(("critical k", _critical(answer)))
    if answer.cycle.basin:
        starts = {"own": "the loop's own", "small": "a small", "large": "a large"}
        ends = {start: VERDICT[reads_as(answer, verdict)].lower() for start, verdict in answer.cycle.basin.items()}
        told = (f"{starts.get(start, start)} start: {end}" for start, end in ends.items())
        pairs.append(("basin", "; ".join(told)))
    return Facts(f"Joint {words.clean(answer.joint)}: gains and margins without friction", tuple(pairs))


def method_facts(sample_time: float) -> Facts:
    """Return what each method does."""
    settles = "run from the loop's own start, a small and a large one, until the averages stand still"
    plain = "run from the loop's own start; read off the second half of the record"
    return Facts(
        "The methods",
        (
            ("describing function", "one harmonic of Tustin friction in closed form, intersected with the linear part; "
             "roots above the Nyquist frequency are left out"),
            ("harmonic balance", "odd harmonics up to the Nyquist frequency, 20 at most, with exact zero crossings; "
             "no sticking phase"),
            ("shooting", "Newton's method on the return map of the event-driven simulation, sticking phases included; "
             "of a sampled loop on the map over the samples after which it repeats"),
            ("simulation", plain if sample_time > 0.0 else settles),
            ("margins", "exact derivatives of the model with its effects; hold, delay, lag and velocity filter by "
             "exact discretisation"),
        ),
    )  # fmt: skip


def _largest(top: KpMax, unit: str) -> str:
    stable = top.why if top.stability is None else f"stable up to {number(top.stability)}{NBSP}{unit}"
    robust = "" if top.ms2 is None else f"Ms at most 2 up to {number(top.ms2)}{NBSP}{unit}"
    why = top.why if top.stability is not None and top.ms2 is None else ""
    return "; ".join(part for part in (stable, robust, why) if part)


def _finds(method: Method, answer: JointAnswer) -> str:
    if method.status == "not_applicable":
        return "not applicable"
    yes = {"ripple": "ripple", "forced": "forced"}.get(reads_as(answer), "yes")
    return {True: yes, False: "none", None: method.status.replace("_", " ")}[method.cycle]


def _numbers(method: Method) -> tuple[str, str, str, str]:
    return (
        _milli(method.amplitude), _error(method.amplitude_error), _value(method.period), _error(method.period_error)
    )  # fmt: skip


def _trust(method: Method) -> str:
    return "yes" if method.trusted else "no"


def _error(value: float | None) -> str:
    if value is None:
        return _DASH
    if abs(value) < 5e-6:
        return f"0{NBSP}%"
    return f"{MINUS if value < 0.0 else '+'}{number(100.0 * abs(value), 2)}{NBSP}%"


def _milli(value: float | None) -> str:
    return _DASH if value is None else milli(value, 4)


def _value(value: float | None) -> str:
    return _DASH if value is None else number(value, 4)


def _stable(value: bool | None) -> str:
    return {True: "yes", False: "no", None: _DASH}[value]


def _multiplier(answer: JointAnswer) -> str:
    roots = answer.cycle.multipliers
    if not roots:
        return _DASH
    largest = max(roots, key=abs)
    if isinstance(largest, complex):
        return f"{number(largest.real)} ± {number(abs(largest.imag))}i"
    return number(largest)


def _critical(answer: JointAnswer) -> str:
    if answer.k_critical is None:
        return answer.k_why
    return "0: it cycles without compensation" if answer.k_critical == 0.0 else number(answer.k_critical, 4)
