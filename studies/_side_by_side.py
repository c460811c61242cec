"""One case answered by all methods in turn, in one process, and the table of many."""

from __future__ import annotations

import tempfile
import time
import warnings
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from statistics import median
from typing import Any

from _decision_fits import diagnosis_of
from _rival import CONSTANTS, Answer, friction_ends
from _rival_least_squares import by_least_squares
from _rival_mujoco import by_mujoco
from _rival_petab import by_petab_select
from _rival_sindy import by_sindy

from stribeck.arm import Arm, load_arm
from stribeck.blind.key import Opened
from stribeck.blind.outcome import outcome
from stribeck.blind.rates import rate
from stribeck.gap.answer.nominal import nominal_intervals
from stribeck.gap.answer.verdict import NAMED_OVER, causes_of, no_gap_probability
from stribeck.gap.diagnose import searched
from stribeck.gap.records.observed import observe
from stribeck.gap.records.prepare import Prepared, prepare
from stribeck.gap.search.setting import Asked
from stribeck.gap.search.step import Step
from stribeck.run import Run

OWN, MUJOCO, EXTENDED, SINDY, ALL = (
    "stribeck", "MuJoCo sysid", "MuJoCo sysid, extended", "PySINDy", "least squares, all effects",
)  # fmt: skip
PETAB = ("AIC", "AICc", "BIC")
METHODS = (OWN, MUJOCO, EXTENDED, SINDY, *(f"PEtab Select {name}" for name in PETAB), ALL)


def answers_of_a_case(arm: Arm, runs: Sequence[Run], leave_out: Sequence[str]) -> dict[str, Any]:
    """Return, as a diagnoser does, this package's names, and beside them every method's answer and processor time.

    All are charged with the preparation of the records, those that use it with the re-tuning, and those that judge
    fits of the search's first step with that step; this package with all of its search.
    """
    clock = _Clock()
    prepared = prepare(arm, runs)
    clock.note("prepared")
    steps = searched(prepared, Asked(jobs=1, leave_out=tuple(leave_out), progress=clock.note)).steps
    own = _own(arm, runs, prepared, steps, leave_out)
    spent, ready, tuned, first = clock.now(), clock.at("prepared"), clock.at("screening"), clock.at("screening", 2)
    step, floor = steps[0], steps[-1].floor
    works: dict[str, tuple[float, Callable[[], Answer]]] = {
        MUJOCO: (ready, lambda: by_mujoco(arm, prepared)),
        EXTENDED: (ready, lambda: by_mujoco(arm, prepared, extended=True)),
        SINDY: (tuned, lambda: by_sindy(arm, prepared, step.base)),
        **{f"PEtab Select {name}": (first, lambda name=name: by_petab_select(arm, step, name)) for name in PETAB},
        ALL: (tuned, lambda: by_least_squares(arm, prepared, step.base, floor, leave_out)),
    }
    answers = {OWN: {**asdict(own), "seconds": spent}}
    answers |= {name: _timed(work, before) for name, (before, work) in works.items()}
    return {"diagnosis": diagnosis_of([(effect, joint, [effect]) for effect, joint in own.named]), "methods": answers}


class _Clock:
    """Processor time at what the search says it does."""

    def __init__(self) -> None:
        self.begun, self.notes = time.process_time(), list[tuple[str, float]]()

    def now(self) -> float:
        return time.process_time() - self.begun

    def note(self, text: str) -> None:
        self.notes.append((text, self.now()))

    def at(self, word: str, number: int = 1) -> float:
        """Return when a text that begins with a word was noted for the number-th time; now, if it was not."""
        times = [at for text, at in self.notes if text.startswith(word)]
        return times[number - 1] if len(times) >= number else self.now()


def _timed(work: Callable[[], Answer], before: float) -> dict[str, Any]:
    begun = time.process_time()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of other packages about themselves, of thresholds that leave no term
            answer: dict[str, Any] = asdict(work())
    except Exception as error:  # of one method: its answer, not the end of the comparison
        answer = {"error": f"{type(error).__name__}: {error}"[:300]}
    return {**answer, "seconds": before + time.process_time() - begun}


def _own(arm: Arm, runs: Sequence[Run], prepared: Prepared, steps: Sequence[Step], leave_out: Sequence[str]) -> Answer:
    """Return what ``stribeck diagnose`` names: effects that the records show by themselves first, as it lists them."""
    floor = steps[-1].floor
    causes, left_over = causes_of(steps, arm.names, prepared.scales)
    named = [
        *observe(arm, runs, prepared.scales, leave_out=leave_out).causes,
        *(c for c in causes if (c.presence or 0.0) > NAMED_OVER),
    ]
    last = steps[-1].best if steps[-1].taken and steps[-1].best is not None else steps[-1].base
    bounds = nominal_intervals(last, prepared, floor)
    keys = [entry.key for entry in last.fit.entries]
    at = [keys.index(f"{joint}.friction.{name}") for joint in arm.names for name in CONSTANTS]
    rows = [(float(last.fit.p[i]), float(bounds.low[i]), float(bounds.high[i])) for i in at]
    nothing = not any(step.taken for step in steps)
    silent = no_gap_probability(steps[0], prepared.noise, floor, prepared.scales) if nothing else left_over
    sure = named[0].presence if named else silent
    places = tuple((cause.effect, cause.joints[0]) for cause in named)
    alike = tuple(named[0].equivalent) if named else ()
    return Answer(places, sure, friction_ends(arm, rows), "a name" if named else "no name", alike=alike)


def table(opened: Opened) -> dict[str, Any]:
    """Return a row a method: what its first name is worth, what its friction is off by, and what it costs."""
    return {
        "digest": opened.digest,
        "cases": len(opened.answers),
        "methods": [{"method": name, **_row(opened, name)} for name in METHODS],
    }


def _row(opened: Opened, method: str) -> dict[str, Any]:
    found = [(opened.truths[name], answer["methods"][method], answer)
             for name, answer in opened.answers.items() if "methods" in answer]  # fmt: skip
    good = [(truth, said, answer) for truth, said, answer in found if "error" not in said]
    rows = [outcome(truth, _first_only(said, answer), opened.settings["library"]) for truth, said, answer in good]
    single, none = ([row for row in rows if row["kind"] == kind] for kind in ("single", "none"))
    errors = [error for truth, said, _ in good for error in _friction_errors(truth, said)]
    counts = [len(said["named"]) for _, said, _ in good]
    wrong_sure = [said["confidence"] for (_, said, _), row in zip(good, rows, strict=True)
                  if row["extra"] and said["confidence"] is not None]  # fmt: skip
    return {
        "failed": len(found) - len(good),
        "right": rate(row["class"] for row in single),
        "exact": rate(row["first"] for row in single),
        "wrong": rate(bool(row["extra"]) for row in single),
        "silent": rate(not row["extra"] for row in none),
        "names": median(counts) if counts else None,
        "confidence_when_wrong": median(wrong_sure) if wrong_sure else None,
        "friction_error": {name: _middle([e["relative"] for e in errors if e["constant"] == name])
                           for name in CONSTANTS},
        "friction_held": rate(error["inside"] for error in errors if error["inside"] is not None),
        "seconds": _middle([said["seconds"] for _, said, _ in found]),
        "says": dict(Counter(said["says"] for _, said, _ in good).most_common(5)),
        "not_converged": sum(said["ended"].startswith("not") for _, said, _ in good),
    }  # fmt: skip


def _first_only(said: Mapping[str, Any], answer: Mapping[str, Any]) -> dict[str, Any]:
    """Return an answer that holds a method's likeliest name alone: a list of all effects is no diagnosis.

    What the method itself says is as likely counts with it.
    """
    first = [(effect, joint, [effect, *said["alike"]]) for effect, joint in said["named"][:1]]
    return {**answer, "diagnosis": diagnosis_of(first)}


def _friction_errors(truth: Mapping[str, Any], said: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Return how far friction is off, relative, and whether the interval holds."""
    with tempfile.TemporaryDirectory(prefix="stribeck-") as folder:
        path = Path(folder) / "arm.toml"
        path.write_text(truth["arm_true"], encoding="utf-8")
        joints = {joint.name: joint.friction for joint in load_arm(path).joints}
    out = []
    for row in said["friction"]:
        true = getattr(joints[row["joint"]], row["constant"])
        off = abs(row["value"] - true)
        known = row["low"] is not None and row["high"] is not None
        inside = bool(row["low"] <= true <= row["high"]) if known else None
        out.append({"constant": row["constant"], "relative": off / true, "inside": inside})
    return out


def _middle(values: Sequence[float]) -> float | None:
    return float(f"{median(values):.3g}") if values else None


def in_words(result: Mapping[str, Any]) -> list[str]:
    """Return the table as lines of text."""
    heads = ("right", "exact", "wrong", "silent", "held")
    lines = [f"{'method':28}" + "".join(f"{head:>8}" for head in heads) + f"{'names':>7}{'C0 off':>8}{'CPU, s':>8}"]
    for row in result["methods"]:
        cells = [row[key] for key in heads[:-1]] + [row["friction_held"]]
        shares = "".join(f"{cell['k']:>4}/{cell['n']:<3}" for cell in cells)
        lines.append(f"{row['method']:28}{shares}{row['names']!s:>7}"
                     f"{row['friction_error']['C0']!s:>8}{row['seconds']!s:>8}")  # fmt: skip
    return lines
