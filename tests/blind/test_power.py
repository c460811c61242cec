"""Power analysis: what is found and what is missed in one's own arm, and that it goes on where it stopped."""

import json
from dataclasses import replace
from pathlib import Path

import pytest

import stribeck
from stribeck.arm import EffectEntry, load_arm
from stribeck.blind import power
from stribeck.blind.farm import Processes
from stribeck.blind.power import _revealed_from, power_analysis
from stribeck.errors import InputError, StribeckError
from stribeck.run import Run, load_run
from stribeck.withheld.own import OwnMaker, own_maker
from stribeck.withheld.plan import LEVELS, Order

EXAMPLE = Path(stribeck.__file__).parent / "example"
CALLS: list[str] = []


def first(run: Run, seconds: float) -> Run:
    rows = run.t <= seconds
    return replace(run, t=run.t[rows], q=run.q[rows], tau=run.tau[rows])


@pytest.fixture
def experiment():
    arm = load_arm(EXAMPLE / "arm.toml")
    return arm, [first(load_run(EXAMPLE / "run_01.csv", 2), 1.5)]


def says(*names: str):
    """A diagnoser that names the same effects in every case, at joint A."""

    def answer(arm, runs, leave_out):
        CALLS.append(arm.name)
        causes = [
            {"effect": n, "joints": ["A"], "probability": 0.9 / len(names), "presence": 0.9, "equivalent": [n],
             "parameters": {}, "closes": None}
            for n in names
        ]  # fmt: skip
        every = [*causes, {"effect": "unknown", "probability": 0.1}]
        return {
            "diagnosis": {"verdict": "explained" if names else "no_gap", "named": list(names), "causes": every,
                          "where": [], "gap": {"closed": None}, "settings": {"cutoff_hz": 10.0}},
            "retuned": "", "corrected": "",
        }  # fmt: skip

    return answer


def analysed(experiment, work, diagnoser, **options):
    options = {"effects": ("delay", "torque_offset"), "levels": ("clear", "weak"), "none": 1, **options}
    return power_analysis(*experiment, work, jobs=1, farm=Processes(1), diagnoser=diagnoser, **options)


@pytest.mark.long
def test_what_is_named_is_revealed(tmp_path, experiment):
    found, score = analysed(experiment, tmp_path / "work", says("delay"))
    assert found["cases"] == 5
    delay, offset = found["effects"]["delay"], found["effects"]["torque_offset"]
    assert (delay["revealed_from"], offset["revealed_from"]) == ("weak", None)
    assert delay["levels"]["clear"]["named"]["k"] == delay["levels"]["weak"]["named"]["k"] == 1
    assert found["not_recorded"] == []
    assert delay["found"]["level"] == "weak"
    assert delay["missed"] is None
    assert offset["missed"]["level"] == "clear"
    assert offset["missed"]["parameters"]["offset"]["unit"] == "N m"
    assert delay["found"]["parameters"]["time"]["value"] > 0.0
    assert delay["found"]["strength"] < delay["levels"]["clear"]["strength"]
    assert found["false_alarms"]["value"] == 1.0  # it names a delay where there is none as well
    assert score["cases"] == 5
    cases = json.loads((tmp_path / "work" / "key.json").read_text(encoding="utf-8"))["cases"].values()
    worth = {c["level"]: c["worth"][e["joint"]] for c in cases for e in c["effects"] if e["effect"] == "delay"}
    assert {level: row["worth"] for level, row in delay["levels"].items()} == pytest.approx(worth, rel=1e-2)
    assert delay["found"]["worth"] == worth["weak"]


@pytest.mark.parametrize(
    ("named", "level"),
    [
        ({"clear": True, "medium": True, "weak": False}, "medium"),
        ({"medium": True, "weak": True}, "weak"),  # what is clear is more than the loop can hold
        ({"clear": True, "weak": True}, "weak"),
        ({"clear": True, "medium": False, "weak": True}, "clear"),
        ({"medium": False, "weak": True}, None),
        ({}, None),
    ],
)
def test_a_level_of_which_nothing_could_be_recorded_is_passed_over(named, level):
    assert _revealed_from([{"level": key, "found": found} for key, found in named.items()], LEVELS) == level


def test_an_effect_that_no_arm_can_be_held_with_is_told(tmp_path, experiment, monkeypatch):
    class Falls(OwnMaker):
        def __call__(self, seed, plan):
            if plan.effects == ("torque_offset",):
                raise StribeckError("falls")
            return super().__call__(seed, plan)

    monkeypatch.setattr(
        power, "own_maker", lambda arm, runs: Falls(**{**vars(own_maker(arm, runs)), "notes": ("told",)})
    )
    found, _ = analysed(experiment, tmp_path / "work", says("delay"), levels=("clear",))
    assert (list(found["effects"]), found["not_recorded"]) == (["delay"], ["torque_offset"])
    assert found["notes"] == ["told"]


@pytest.mark.long
def test_the_same_call_goes_on_and_another_is_refused(tmp_path, experiment):
    little = {"effects": ("delay",), "levels": ("clear",), "none": 1}
    once, _ = analysed(experiment, tmp_path / "work", says(), **little)
    before = len(CALLS)
    again, _ = analysed(experiment, tmp_path / "work", says(), **little)
    assert again == once
    assert len(CALLS) == before
    with pytest.raises(InputError, match="holds another analysis"):
        analysed(experiment, tmp_path / "work", says(), **{**little, "none": 2})


def test_where_nothing_is_recorded_another_call_goes_on(tmp_path, experiment, monkeypatch):
    """One that failed leaves no folder; one that was killed leaves a folder that the next call takes."""
    work = tmp_path / "work"
    arm, runs = experiment
    with pytest.raises(InputError, match="an arm with effects of its own cannot be recorded"):
        analysed((replace(arm, effects=(EffectEntry("delay", ("A",)),)), runs), work, says())
    assert not work.exists()

    def stop(*args, **options):
        raise KeyboardInterrupt

    monkeypatch.setattr(power, "record_sealed", stop)
    with pytest.raises(KeyboardInterrupt):
        analysed(experiment, work, says())
    assert not work.exists()
    power._begin(work, power._fingerprint(arm, runs, Order(none=1), 0))
    (work / ".cases.part").mkdir()
    other = power._fingerprint(arm, runs, Order(none=2), 0)
    power._begin(work, other)
    assert json.loads((work / "power.json").read_text()) == other
    assert [path.name for path in work.iterdir()] == ["power.json"]


def test_the_power_of_a_report_is_no_folder_of_work(tmp_path, experiment):
    (tmp_path / "power.json").write_text(json.dumps({"schema": power.SCHEMA, "effects": {}}))
    (tmp_path / "report.html").touch()
    with pytest.raises(InputError, match="holds another analysis"):
        analysed(experiment, tmp_path, says())
    assert sorted(path.name for path in tmp_path.iterdir()) == ["power.json", "report.html"]


def test_a_folder_of_something_else_is_left_alone(tmp_path, experiment):
    (tmp_path / "mine.txt").touch()
    with pytest.raises(InputError, match="not a folder of a power analysis"):
        analysed(experiment, tmp_path, says())
    assert [path.name for path in tmp_path.iterdir()] == ["mine.txt"]
