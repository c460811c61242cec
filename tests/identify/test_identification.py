"""`stribeck identify` as a whole: both directions, its files, and recordings that tell too little."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pyarrow as pa
import pytest

from stribeck.arm import Arm, EffectEntry, Friction, Joint, load_arm, save_arm
from stribeck.cli import main
from stribeck.errors import InputError
from stribeck.identify.doubts import TAKEN
from stribeck.identify.files import identification_json
from stribeck.identify.findings import WAYS, Identification
from stribeck.identify.identification import identify_friction
from stribeck.identify.tustin_fit import NAMES, tustin
from stribeck.run import Run, save_run

from .bench import BACKWARD, FORWARD, breaking, campaign, joint, sliding
from .conftest import PENDULUM, hoisted, pendulum, recorded, stronger

WRONG = Friction(2.0, 0.5, 0.5, 0.1)  # what the arm file says: anyone's guess


def values(friction: Friction) -> np.ndarray:
    return np.array([getattr(friction, name) for name in NAMES])


@pytest.fixture(scope="module", params=[0.0, 9.81], ids=["level", "vertical"])
def found(request: pytest.FixtureRequest) -> Identification:
    return identify_friction(joint(WRONG, WRONG, request.param), campaign(request.param))


@pytest.mark.long
def test_both_directions_are_found(found: Identification) -> None:
    """From a wrong arm file, in either plane."""
    (one,) = found.joints
    speed = np.geomspace(0.01, 1.0, 50)
    for way, true in (("forward", FORWARD), ("backward", BACKWARD)):
        direction = one.directions[way]
        assert direction.source == "curve"
        assert direction.curve.level(speed) == pytest.approx(tustin(values(true), speed), rel=0.01)
        assert direction.section3 is not None
    assert one.asymmetric
    assert (found.arm.joints[0].friction, found.arm.joints[0].backward) != (WRONG, WRONG)
    assert found.arm.joints[0].friction != found.arm.joints[0].backward


def test_section_3_stands_beside_it(found: Identification) -> None:
    """With hardly any noise it is close too, where its saddle happens to be among the velocities tried."""
    steps = found.joints[0].directions["forward"].section3
    assert steps is not None
    assert steps.ok
    assert steps.constants[0] == pytest.approx(FORWARD.C0, rel=0.03)
    assert steps.break_away == pytest.approx(FORWARD.C0 + FORWARD.C1, rel=0.01)


def test_runs_of_a_joint_whose_counter_begins_anew_are_read_in_one_turn() -> None:
    """One begins a little before half a turn, the other a little beyond."""
    runs = []
    for k, begins in enumerate((-0.01, 0.01)):
        one = recorded(seed=k)
        q = one.q - one.q[0] + begins  # half a turn less, as the counter has it
        runs.append(replace(one, name=f"run_{k}", q=q % (2.0 * np.pi) - np.pi))
    said = identify_friction(pendulum(), runs).notes
    assert sum("moved by whole turns to where the other recordings are: q1" in note for note in said) == 1


def test_whole_runs_are_fitted_too(found: Identification) -> None:
    speed = np.geomspace(0.02, 1.0, 50)
    own = found.joints[0].directions["forward"].runs[0]
    assert found.whole.fit.ok
    assert tustin(own, speed) == pytest.approx(tustin(values(FORWARD), speed), rel=0.05)


def test_json_holds_it_all(found: Identification) -> None:
    content = json.loads(json.dumps(identification_json(found), allow_nan=False))
    assert content["schema"] == "stribeck.identification/1"
    one = content["joints"]["A"]["directions"]["forward"]
    for name in NAMES:
        low, high = one["curve"]["constants"][name]["ci95"]
        assert low <= one["curve"]["constants"][name]["value"] <= high
    assert one["section3"]["condition_2"] > 0.0
    assert len(one["readings"]["velocity"]) == one["curve"]["readings"]
    assert content["units"]["C2"] == "N m s/rad"


def test_a_law_that_multiplies_friction_takes_the_whole_recordings() -> None:
    wave = EffectEntry("position_dependent_friction", ("A",), {"A": {"sine": 0.02, "harmonic": 2.0}}, "one_wave")
    runs = [sliding(speed) for speed in (0.01, 0.04, 0.15, 0.6, 1.0)] + [breaking(1, seed=k) for k in range(2)]
    for effects, taken in (((), "curve"), ((wave,), "runs")):
        found = identify_friction(replace(joint(WRONG, WRONG), effects=effects), runs)
        assert found.joints[0].directions["forward"].source == taken
        assert any("goes with Tustin's friction" in text for text in found.warnings) == (taken == "runs")


def test_recordings_of_unlike_noise() -> None:
    """Where the noisier ones rest, no friction is read into them."""
    rng = np.random.default_rng(3)
    noisy = [breaking(1, rate=0.8, seed=k) for k in range(2)]
    noisy = [replace(run, q=run.q + 2e-5 * rng.standard_normal(run.q.shape)) for run in noisy]
    found = identify_friction(joint(WRONG, WRONG), [*(sliding(speed) for speed in (0.02, 0.04, 0.1, 0.3, 0.6)), *noisy])
    own = found.joints[0].directions["forward"].runs[0]
    assert found.whole.fit.at_limit == ()
    assert own[0] == pytest.approx(FORWARD.C0, rel=0.02)


def test_an_axis_is_spoken_of_in_metres() -> None:
    """Driven like the joint of the bench, whose inertia it has for a mass."""
    own = joint().joints[0]
    axis = Joint("A", "prismatic", 0.0, 0.51, (0.0, 0.0), 0.0, 0.49, own.friction, own.friction)
    found = identify_friction(Arm("axis", (0.0, 0.0), (axis,)), [sliding(speed) for speed in (0.15, 0.3, 0.6)])
    by_hand = found.joints[0].directions["forward"].section3
    assert by_hand is not None
    assert any(" m/s" in text for text in by_hand.remarks)
    assert not any("rad" in text for text in by_hand.remarks)


def test_recordings_that_never_slide_steadily() -> None:
    """Only the fit to whole recordings is given, and it is right; the report says so."""
    truth = stronger(PENDULUM, C0=1.3, C2=1.2)
    runs = [replace(recorded(truth, rate=250.0, noise=1e-5, seed=k), name=f"run {k}") for k in range(2)]
    found = identify_friction(pendulum(), runs)
    (one,) = found.joints
    assert {direction.source for direction in one.directions.values()} == {"runs"}
    assert {direction.section3 for direction in one.directions.values()} == {None}
    assert any("never slides steadily" in text for text in found.warnings)
    fitted = found.arm.joints[0]
    assert values(fitted.friction)[[0, 2]] == pytest.approx(values(truth.friction)[[0, 2]], rel=0.03)


def test_friction_is_taken_with_the_masses_that_it_was_fitted_with() -> None:
    """Of a vertical axis neither is determined; together they hold against gravity."""
    heavy = replace(PENDULUM, mass=6.0, rotor_inertia=1.0)
    arm, run = hoisted(heavy, noise=1e-6)
    (own,) = arm.joints
    found = identify_friction(replace(arm, joints=(replace(own, mass=6.3, friction=WRONG, backward=WRONG),)), [run])
    assert not any(one.runs_identified[0] for one in found.joints[0].directions.values())
    fitted = found.arm.joints[0]
    for friction, true, way in ((fitted.friction, own.friction, 1.0), (fitted.backward, own.backward, -1.0)):
        borne = 9.81 * (fitted.mass - own.mass)
        assert way * friction.C0 - borne == pytest.approx(way * true.C0, abs=0.1)
    for way in WAYS.values():
        (told,) = (text for text in found.warnings if text.startswith(f"A, {way}: the recordings do not tell C0"))
        assert told.endswith(TAKEN["runs"])


def test_a_joint_that_never_moves_keeps_its_constants() -> None:
    rng = np.random.default_rng(0)
    q, tau = 1e-5 * rng.standard_normal((600, 1)), rng.standard_normal((600, 1))
    found = identify_friction(joint(WRONG, WRONG), [Run("still", 0.005 * np.arange(600), q, tau)])
    assert found.arm.joints[0].friction == WRONG
    assert any("it never moved" in text for text in found.warnings)


def test_too_short() -> None:
    run = Run("short.csv", 0.005 * np.arange(30), np.zeros((30, 1)), np.zeros((30, 1)))
    with pytest.raises(InputError, match=r"short\.csv: too short to identify from: found 30 samples"):
        identify_friction(joint(), [run])


def test_too_short_for_the_filters() -> None:
    """Samples enough, but of a fast clock: no row is left."""
    t = 0.001 * np.arange(70)
    run = Run("brief.csv", t, np.sin(9.0 * t)[:, None], np.cos(9.0 * t)[:, None])
    with pytest.raises(InputError, match=r"too short to identify from: found the longest .*brief\.csv, takes 0\.06"):
        identify_friction(joint(), [run])


def test_runs_of_one_name_are_refused() -> None:
    with pytest.raises(InputError, match="two runs have the same name: found "):
        identify_friction(joint(), [recorded(noise=1e-5), recorded(noise=2e-5)])


@pytest.fixture
def bench(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    save_arm(pendulum(), "arm.toml")
    run = recorded(rate=250.0, noise=1e-5)
    save_run(replace(run, extra=pa.table({"mode": np.zeros(len(run.t))})), "run.csv")
    return tmp_path


@pytest.mark.usefixtures("bench")
def test_command_writes_its_files(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["identify", "arm.toml", "run.csv", "--out", "out"]) == 0
    assert sorted(path.name for path in Path("out").iterdir()) == [
        "fitted.toml", "friction_curve.png", "identification.json", "report.html",
    ]  # fmt: skip
    assert load_arm("out/fitted.toml").n == 1
    page = Path("out/report.html").read_text(encoding="utf-8")
    assert "never slides steadily" in page
    assert "<script" not in page
    output = capsys.readouterr()
    assert "from whole recordings" in output.out
    assert (output.out + output.err).count("warning: run.csv: columns not used: mode") == 1
    assert "Traceback" not in output.err


@pytest.mark.usefixtures("bench")
@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        ("identify arm.toml --out out", "Missing argument 'RUN'"),
        ("identify arm.toml gone.csv --out out", "gone.csv: cannot be read"),
        ("identify gone.toml run.csv --out out", "gone.toml: cannot be read"),
        ("identify arm.toml run.csv run.csv --out out", "a run is given twice"),
        ("identify arm.toml run.csv", "Missing option '--out'"),
    ],
)
def test_bad_arguments(arguments: str, says: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(arguments.split()) == 2
    error = capsys.readouterr().err
    assert says in error
    assert error.count("\n") == 1
    assert not Path("out").exists()


@pytest.mark.usefixtures("bench")
@pytest.mark.parametrize(
    ("old", "new", "says"),
    [("alpha = ", "alpha = 0.0 # ", "alpha must be greater than 0"), ("C1 = ", "C1 = -1.0 # ", "C1")],
)
def test_an_arm_that_is_none(old: str, new: str, says: str, capsys: pytest.CaptureFixture[str]) -> None:
    text = Path("arm.toml").read_text(encoding="utf-8")
    Path("arm.toml").write_text(text.replace(old, new, 1), encoding="utf-8")
    assert main(["identify", "arm.toml", "run.csv", "--out", "out"]) == 2
    error = capsys.readouterr().err
    assert says in error
    assert error.count("\n") == 1
    assert not Path("out").exists()


def test_a_disturbance_of_the_arm_file_is_left_out_and_told() -> None:
    """No file says at what phase a run meets it."""
    wave = EffectEntry("input_disturbance", ("A",), {"A": {"sine": 2.0, "cosine": 0.0, "frequency": 2.0}}, "one_wave")
    run = recorded(noise=1e-6)
    plain, found = (identify_friction(arm, [run]) for arm in (pendulum(), replace(pendulum(), effects=(wave,))))
    assert found.arm.joints == plain.arm.joints
    assert found.arm.effects == found.nominal.effects == (wave,)
    assert any("input_disturbance drives the arm in time" in text for text in found.warnings)
    assert not any("drives the arm" in text for text in plain.warnings)
