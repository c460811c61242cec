"""Sealed cases: folders that tell nothing, and a key of which only the digest is shown before the answers are in."""

from __future__ import annotations

import hashlib
import json
import math
import os
import secrets
from collections.abc import Callable, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import numpy as np
from joblib import Parallel, delayed

from stribeck.arm import Arm, arm_to_toml, save_arm
from stribeck.errors import InputError, StribeckError
from stribeck.outputs import check_free, whole_file, whole_folder
from stribeck.run import Run, save_run
from stribeck.textfile import read_whole
from stribeck.version import package_version
from stribeck.withheld.cases import Case, make_case
from stribeck.withheld.plan import Order, Plan, plans

KEY_SCHEMA, CASE_SCHEMA = "stribeck.withheld-key/1", "stribeck.withheld-case/1"
DIGEST = "digest.txt"
ANSWERS_LATER = "SHA-256 of the sealed answers"
TRIES = 5  # arms drawn anew, where one cannot be held with its effect
DIGITS = 6  # of a torque, against the joint's limit; a position keeps a thousandth of an encoder count

Maker = Callable[[int, Plan], Case]
Progress = Callable[[str], None]


def drawn_case(seed: int, plan: Plan) -> Case:
    """Return a case of a drawn arm and drawn motions."""
    return make_case(
        seed, plan.effects or None, plan.level, plan.joints, disturbed=plan.disturbed, smooth=plan.smooth
    )  # fmt: skip


def record_sealed(
    order: Order,
    out: Path,
    key: Path,
    *,
    seed: int | None = None,
    jobs: int = 2,
    make: Maker = drawn_case,
    progress: Progress = lambda text: None,
) -> str:
    """Record cases into a new folder, their answers into a key file; return the digest of the key.

    Parameters
    ----------
    order : Order
        How many cases of which kind.
    out : path
        New folder: ``digest.txt`` and a folder a case with ``arm.toml``, ``case.json`` and the runs.
    key : path
        New file outside of `out`: seeds, effects, parameters, strengths, true arms, and a salt.
    seed : int or None
        Of everything drawn; drawn itself where None, so that nobody can record the same cases without the key.
    jobs : int
        Processes.
    make : callable
        Returns the case of a seed and a plan; it must be one that processes can be given.
    progress : callable
        Told in words what is being done.

    Raises
    ------
    InputError
        For an order that cannot be recorded, or places that cannot be written.
    """
    order = order.checked()
    check_free(out)
    _check_key(key, out)
    seed = secrets.randbits(62) if seed is None else seed
    wanted = plans(order, np.random.default_rng([seed, 1]))
    seeds = np.random.default_rng([seed, 2]).integers(2**53, size=(len(wanted), TRIES))
    width = max(4, len(str(len(wanted))))
    with whole_folder(out) as folder, whole_file(key) as part:  # a place that cannot be written is told now
        names = [f"case_{i:0{width}d}" for i in range(1, len(wanted) + 1)]
        work = (
            delayed(_record)(make, plan, [int(s) for s in own], folder / name)
            for name, plan, own in zip(names, wanted, seeds, strict=True)
        )
        truths: dict[str, dict[str, Any]] = {}
        skipped: list[str] = []
        for name, truth in zip(names, Parallel(n_jobs=jobs, return_as="generator")(work), strict=True):
            if isinstance(truth, str):
                skipped.append(truth)
                progress(f"{name} cannot be recorded and is left out: {truth}")
            else:
                truths[name] = truth
                progress(f"{len(truths)} of {len(wanted)} cases recorded")
        if not truths:
            raise StribeckError("none of the cases can be recorded", skipped[0], "see which --effects the arm can hold")
        digest = _seal({"order": asdict(order), "skipped": skipped, "cases": truths}, seed, folder, part)
    return digest


def _seal(answers: dict[str, Any], seed: int, folder: Path, part: Path) -> str:
    """Write digest and key; the salt keeps the digest from being found by guessing."""
    head = {"schema": KEY_SCHEMA, "version": package_version(), "units": "SI", "salt": secrets.token_hex(32)}
    content = {**head, "seed": seed, **answers}
    text = (json.dumps(content, indent=1, allow_nan=False) + "\n").encode("utf-8")
    digest = hashlib.sha256(text).hexdigest()
    (folder / DIGEST).write_text(f"{digest}  {ANSWERS_LATER}\n", encoding="utf-8")
    part.write_bytes(text)
    return digest


def read_digest(folder: Path) -> str:
    """Return the digest that a folder of cases shows; raise `InputError` where there is none."""
    path = folder / DIGEST
    try:
        words = read_whole(path, "record the cases anew").decode("utf-8").split()
    except (OSError, UnicodeDecodeError):
        raise InputError(f"{folder}: not a folder of sealed cases", f"no {DIGEST}", "record them first") from None
    if not words or len(words[0]) != 64:
        raise InputError(f"{path}: not a digest", " ".join(words[:1]), "record the cases anew")
    return words[0]


def digest_of_files(files: dict[str, bytes]) -> str:
    """Return one SHA-256 of all files of a case, by name."""
    total = hashlib.sha256()
    for name in sorted(files):
        total.update(name.encode() + b"\0" + hashlib.sha256(files[name]).digest())
    return total.hexdigest()


def _check_key(key: Path, out: Path) -> None:
    if key.exists():
        raise InputError(f"{key}: the key file exists", "", "give a new file: other cases may need this one")
    true = Path(os.path.realpath(key))  # not resolve(): it raises where links go round in a circle
    if Path(os.path.realpath(out)) in (true, *true.parents):
        raise InputError(f"{key}: the key would lie among the cases", str(out), "give a file elsewhere")


def _record(make: Maker, plan: Plan, seeds: Sequence[int], folder: Path) -> dict[str, Any] | str:
    """Record one case, write its folder, return its answer; in words where no arm can be held with its effects."""
    for seed in seeds:
        try:
            case = make(seed, plan)
        except StribeckError as error:
            if isinstance(error, InputError):
                raise
            last = f"{' and '.join(plan.effects)} ({plan.level}): {error}"
            continue
        return _write(case, plan, folder)
    return last


def _write(case: Case, plan: Plan, folder: Path) -> dict[str, Any]:
    folder.mkdir()
    save_arm(case.arm_nominal, folder / "arm.toml")
    note = {"schema": CASE_SCHEMA, "leave_out": list(plan.leave_out)}
    (folder / "case.json").write_text(json.dumps(note) + "\n", encoding="utf-8")
    for run in case.runs:
        save_run(rounded(run, case.arm_nominal), folder / f"{run.name}.csv")
    files = {path.name: path.read_bytes() for path in folder.iterdir()}
    return {
        "kind": plan.kind,
        "files": digest_of_files(files),
        "leave_out": list(plan.leave_out),
        **case.truth,
        "arm_true": arm_to_toml(case.arm_true),
        "arm_nominal": arm_to_toml(case.arm_nominal),
    }


def rounded(run: Run, arm: Arm) -> Run:
    """Return a run with digits that mean something, as many as the nominal arm asks for, whatever is hidden."""
    counts = np.array([joint.encoder_resolution or 1e-9 for joint in arm.joints])
    limits = np.array([joint.torque_limit or 1e3 for joint in arm.joints])
    angle = 3 - math.floor(math.log10(counts.min()))
    torque = DIGITS - math.floor(math.log10(limits.min()))
    places = {"t": 9, "q": angle, "dq": angle, "q_ref": angle, "dq_ref": angle, "tau": torque, "tau_meas": torque}
    values = {name: getattr(run, name) for name in places}
    return replace(run, **{n: np.round(v, places[n]) for n, v in values.items() if v is not None})
