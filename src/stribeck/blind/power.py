"""Power analysis: which effects, and how strong, an experiment of the user's own would have revealed."""

from __future__ import annotations

import hashlib
import json
import shutil
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from stribeck.arm import Arm, arm_to_toml, unit_at
from stribeck.blind.answer import Diagnoser, diagnosed
from stribeck.blind.batch import diagnose_cases, write_json
from stribeck.blind.comparable import law_for, true_values
from stribeck.blind.farm import Farm, Processes
from stribeck.blind.key import Opened, open_sealed
from stribeck.blind.rates import rate
from stribeck.blind.score import score
from stribeck.errors import InputError
from stribeck.run import Run
from stribeck.textfile import read_whole
from stribeck.withheld.own import own_maker
from stribeck.withheld.plan import LEVELS, Order
from stribeck.withheld.seal import record_sealed

SCHEMA = "stribeck.power/1"
ENOUGH = 0.5  # of the cases at a level, named: then the experiment reveals effects of that level


def power_analysis(
    arm: Arm,
    runs: Sequence[Run],
    work: Path,
    *,
    effects: Sequence[str] = (),
    levels: Sequence[str] = LEVELS,
    each: int = 1,
    none: int = 4,
    seed: int = 0,
    jobs: int = 2,
    farm: Farm | None = None,
    diagnoser: Diagnoser = diagnosed,
    progress: Callable[[str], None] = lambda text: None,
) -> tuple[dict[str, Any], dict[str, Any]]:
    """Hide effects in an arm, record its own motions, diagnose them, and say which were found.

    Parameters
    ----------
    arm : Arm
        The nominal arm; those that record are drawn from it within its tolerance.
    runs : sequence of Run
        The experiment: its references, or else its recorded motions, are tracked anew.
    work : path
        Folder of cases and answers; a call with the same arguments goes on where the last one stopped.
    effects : sequence of str
        To hide; all that the arm can have where empty.
    levels : sequence of str
        How strong, see `stribeck.withheld.severity`.
    each, none : int
        Cases of each effect and level, and without an effect.
    seed, jobs : int
        Of everything drawn; processes that record.
    farm, diagnoser, progress
        See :func:`stribeck.blind.batch.diagnose_cases`.

    Returns
    -------
    power, score : dict
        The contents of ``power.json`` and ``score.json``.

    Raises
    ------
    InputError
        For an arm or effects that cannot be recorded, or a `work` folder of another analysis.
    """
    maker = own_maker(arm, runs)
    names = maker.effects(effects)
    order = Order(single=each * len(names) * len(levels), none=none, effects=names, levels=tuple(levels)).checked()
    _begin(work, _fingerprint(arm, runs, order, seed))
    key = work / "key.json"
    if not key.exists():
        try:
            record_sealed(order, work / "cases", key, seed=seed, jobs=jobs, make=maker, progress=progress)
        except BaseException:
            if not key.exists():  # nothing is recorded yet, and the next call may well be another
                shutil.rmtree(work, ignore_errors=True)
            raise
    answers = work / "answers"
    diagnose_cases(work / "cases", answers, farm=farm or Processes(jobs), diagnoser=diagnoser, progress=progress)
    opened = open_sealed(answers, key)
    scored = score(opened)
    return power(scored, opened, arm, [run.name for run in runs], order, maker.notes), scored


def power(
    scored: Mapping[str, Any], opened: Opened, arm: Arm, runs: Sequence[str], order: Order, notes: Sequence[str] = ()
) -> dict[str, Any]:
    """Return the content of ``power.json`` from a score, its truths and what was to be recorded.

    ``effects`` holds for each effect ``revealed_from`` (the weakest level from which on at least half of the cases are
    named; null: none), ``levels`` (named rate, mean strength and worth), ``found`` and ``missed`` (the weakest case
    that was named and the strongest that was not: strength, worth, joint, parameters with units) and
    ``detection_limit`` (strength); ``worth`` is the effect's share of the torque that moves the joint.
    ``not_recorded`` names the effects that no arm could be held with; ``notes`` tell what was done to the recordings.

    Parameters
    ----------
    scored : mapping
        As :func:`stribeck.blind.score.score` returns it.
    opened : Opened
        Answers and truths.
    arm : Arm
        The nominal arm.
    runs : sequence of str
        Names of the recordings of the experiment.
    order : Order
        What was to be recorded.
    notes : sequence of str
        What was done to the recordings.
    """
    rows = [row for row in scored["rows"] if len(row["effects"]) == 1]
    effects = {}
    for name in sorted({row["effects"][0] for row in rows}):
        own = sorted((row for row in rows if row["effects"] == [name]), key=lambda row: float(row["strength"]))
        found, missed = [r for r in own if r["found"]], [r for r in own if not r["found"]]
        effects[name] = {
            "revealed_from": _revealed_from(own, order.levels),
            "levels": {level: _level([r for r in own if r["level"] == level], opened) for level in order.levels},
            "found": _example(found[0], opened, arm) if found else None,
            "missed": _example(missed[-1], opened, arm) if missed else None,
            "detection_limit": scored["effects"].get(name, {}).get("detection_limit"),
        }
    return {
        "schema": SCHEMA,
        "version": scored["version"],
        "units": {
            "strength": "effect torque over noise floor",
            "worth": "effect torque over torque that moves the joint",
        },
        "arm": arm.name,
        "runs": list(runs),
        "cases": len(scored["rows"]),
        "false_alarms": scored["none"]["false_alarms"],
        "wrong_names": scored["single"]["all"]["wrong_name"],
        "effects": effects,
        "not_recorded": [name for name in order.effects if name not in effects],
        "notes": list(notes),
    }


def _level(rows: Sequence[Mapping[str, Any]], opened: Opened) -> dict[str, Any]:
    found = rate(bool(row["found"]) for row in rows)
    strengths, worths = [float(row["strength"]) for row in rows], [_worth(row, opened) for row in rows]
    return {"named": found, "strength": _mean(strengths), "worth": _mean(worths)}


def _worth(row: Mapping[str, Any], opened: Opened) -> float:
    truth = opened.truths[row["case"]]
    return float(truth["worth"][truth["effects"][0]["joint"]])


def _mean(values: Sequence[float]) -> float | None:
    return float(f"{sum(values) / len(values):.3g}") if values else None


def _revealed_from(rows: Sequence[Mapping[str, Any]], levels: Sequence[str]) -> str | None:
    """Return the weakest level such that it and all clearer ones, as far as recorded, are named often enough."""
    weakest = None
    for level in (known for known in LEVELS if known in levels):  # the clearest first
        named = [bool(row["found"]) for row in rows if row["level"] == level]
        if sum(named) < ENOUGH * len(named):
            break
        weakest = level if named else weakest
    return weakest


def _example(row: Mapping[str, Any], opened: Opened, arm: Arm) -> dict[str, Any]:
    effect = opened.truths[row["case"]]["effects"][0]
    values = true_values(effect["effect"], effect["parameters"])
    known = law_for(effect["effect"], effect["parameters"])
    units = {p.name: p.unit for p in known.parameters} if known else {}
    kind = arm.joints[0].kind
    parameters = {name: {"value": float(f"{v:.4g}"), "unit": unit_at(units[name], kind)} for name, v in values.items()}
    size = {"strength": row["strength"], "worth": _worth(row, opened)}
    return {**size, "level": row["level"], "joint": effect["joint"], "parameters": parameters}


def _fingerprint(arm: Arm, runs: Sequence[Run], order: Order, seed: int) -> dict[str, Any]:
    total = hashlib.sha256(arm_to_toml(arm).encode())
    for run in runs:
        for values in (run.t, run.q, run.tau, run.q_ref):
            total.update(b"-" if values is None else values.tobytes())
    # through JSON, as it will be read: tuples are lists there
    wanted = {"schema": SCHEMA, "experiment": total.hexdigest(), "order": asdict(order), "seed": seed}
    return dict(json.loads(json.dumps(wanted)))


def _begin(work: Path, wanted: Mapping[str, Any]) -> None:
    """Make the folder, or find it begun; what stopped before anything was recorded is begun anew."""
    path = work / "power.json"
    if not path.exists():
        if work.exists() and any(work.iterdir()):
            raise InputError(f"{work}: not a folder of a power analysis", "no power.json", "give a new folder")
        write_json(path, wanted)
        return
    try:
        before = json.loads(read_whole(path, "remove the folder"))
    except (OSError, ValueError) as error:
        raise InputError(f"{path}: cannot be read", str(error), "remove the folder") from None
    begun = isinstance(before, dict) and before.keys() == wanted.keys()  # the power.json of a report is another
    if begun and not (work / "key.json").exists():
        shutil.rmtree(work, ignore_errors=True)
        write_json(path, wanted)
    elif before != wanted:
        raise InputError(f"{work}: holds another analysis", "", "use the same arm, runs and options, or remove it")
