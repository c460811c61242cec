"""Runs: exact round trips, plausible warnings, and one line with row and value for every fault."""

import dataclasses
import os
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from stribeck.errors import InputError, StribeckError
from stribeck.run import Run, check_apart, load_run, load_runs, save_run

REAL = Path(__file__).parents[2] / "shared" / "data" / "dfki-double-pendulum"
FORMATS = [".csv", ".parquet"]


def a_run(rows: int = 40) -> Run:
    t = 0.01 * np.arange(rows)
    q = np.column_stack([np.sin(3 * t), np.cos(2 * t)])
    dq = np.column_stack([3 * np.cos(3 * t), -2 * np.sin(2 * t)])
    return Run("a", t, q, tau=10 * q, dq=dq, q_ref=q, dq_ref=dq, tau_meas=9 * q, temperature=20 + q)


def csv_rows(rows: int = 20) -> list[str]:
    return ["t,q1,tau1", *(f"{0.01 * i:.2f},{0.1 * i:.3f},{0.5 * i:.3f}" for i in range(rows))]


def load_lines(tmp_path: Path, lines: list[str], n: int = 1) -> Run:
    path = tmp_path / "run.csv"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return load_run(path, n)


@pytest.mark.parametrize("suffix", FORMATS)
def test_round_trip_keeps_every_column(tmp_path: Path, suffix: str) -> None:
    run = dataclasses.replace(a_run(), extra=pa.table({"note, with comma": ["x"] * 40, "speed": [1.5] * 40}))
    path = tmp_path / f"run{suffix}"
    save_run(run, path)
    back = load_run(path, 2)
    assert back.name == f"run{suffix}"
    for key in ("t", "q", "tau", "dq", "q_ref", "dq_ref", "tau_meas", "temperature"):
        np.testing.assert_array_equal(getattr(back, key), getattr(run, key), err_msg=key)
    assert back.extra is not None
    assert back.extra["note, with comma"].to_pylist() == ["x"] * 40
    assert back.warnings == ("columns not used: note, with comma, speed",)
    assert os.listdir(tmp_path) == [path.name]


def test_csv_is_plain(tmp_path: Path) -> None:
    save_run(a_run(), tmp_path / "run.csv")
    header, first = (tmp_path / "run.csv").read_text().splitlines()[:2]
    assert header.startswith("t,q1,q2,tau1,tau2,dq1,dq2,q1_ref,q2_ref,dq1_ref,dq2_ref,tau1_meas,tau2_meas,temperature1")
    assert first.startswith("0,0,1,0,10,3,")


@pytest.mark.parametrize("suffix", FORMATS)
@given(values=arrays(float, (16, 2), elements=st.floats(-1000, 1000)))
def test_round_trip_is_exact(suffix: str, values: np.ndarray, tmp_path_factory: pytest.TempPathFactory) -> None:
    path = tmp_path_factory.getbasetemp() / f"exact{suffix}"
    run = Run("x", np.cumsum(1e-3 + 1e-4 * np.abs(values[:, 0])), values[:, :1], values[:, 1:])
    save_run(run, path)
    back = load_run(path, 1)
    np.testing.assert_array_equal(back.t, run.t)
    np.testing.assert_array_equal(back.q, run.q)
    np.testing.assert_array_equal(back.tau, run.tau)


def test_optional_columns_may_be_absent_or_incomplete(tmp_path: Path) -> None:
    plain = load_lines(tmp_path, csv_rows())
    assert (plain.dq, plain.tau_meas, plain.extra, plain.gaps, plain.warnings) == (None, None, None, None, ())
    assert (plain.n, plain.duration, plain.sample_time) == (1, pytest.approx(0.19), pytest.approx(0.01))
    lines = [f"{line},{'q2,tau2,dq2' if i == 0 else '0,0,0'}" for i, line in enumerate(csv_rows())]
    part = load_lines(tmp_path, lines, 2)
    assert part.dq is None
    assert part.warnings == ("columns not used: dq2",)


@pytest.mark.parametrize(
    ("row", "line", "says"),
    [
        (5, "x,0,0", "column t, row 5: not a number: found 'x'"),
        (5, "0.04,fast,0", "column q1, row 5: not a number: found 'fast'"),
        (20, "0.19,0,", "column tau1, row 20: not a number: found an empty cell"),
        (5, "0.04,0,nan", "column tau1, row 5: not a finite number: found nan"),
        (5, "0.04,-inf,0", "column q1, row 5: not a finite number: found -inf"),
        (5, "0.04,1e999,0", "column q1, row 5: not a finite number: found 1e999"),
        (5, "0.04,0", "row 5 must have 3 values, as the header: found 2"),
        (5, "0.04,0,0,0", "row 5 must have 3 values, as the header: found 4"),
        (5, "0.01,0,0", "column t, row 5 goes back in time: found 0.01 after 0.02"),
        (5, "0.02,0,0", "column t, row 5 repeats the time of the row before: found 0.02 after 0.02"),
        (5, "0.03,5000,0", "column q1 is beyond 1000 rad: found 5000"),
        (5, "0.03,0,-2e6", "column tau1 is beyond 1e+06 N m: found 2e+06"),
        (1, "t,q1,tau", "column tau1 is missing: found t, q1, tau"),
        (1, "time,pos,torque", "columns missing: t, q1, tau1"),
        (1, "t,q1,q1", "two columns have the same name: found 'q1'"),
        (1, "t;q1;tau1", "row 1 names no columns"),
        (1, "0,0,0", "row 1 is no header, but numbers: found 0,0,0; write the names of the columns above it"),
    ],
)
def test_fault_is_said_with_its_row(tmp_path: Path, row: int, line: str, says: str) -> None:
    lines = csv_rows()
    lines[row - 1] = line
    with pytest.raises(InputError) as caught:
        load_lines(tmp_path, lines)
    assert str(caught.value).startswith(f"{tmp_path / 'run.csv'}: {says}")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("header", "n", "does"),
    [
        ("t [s],q1 [rad],tau1 [Nm]", 1, "rename 't [s]' to t, 'q1 [rad]' to q1, 'tau1 [Nm]' to tau1; the header must"),
        ("T,Q1,TAU1", 1, "rename 'T' to t, 'Q1' to q1, 'TAU1' to tau1; the header must name them exactly: t, q1, tau1"),
        ("time,pos,torque_cmd", 1, "rename 'time' to t, 'pos' to q1, 'torque_cmd' to tau1; "),
        ("t,q1,q_2,tau1,torque 2", 2, "rename 'q_2' to q2, 'torque 2' to tau2; "),
        ("t,q1,tau1", 2, "the header must name them exactly: t, q1, q2, tau1, tau2 (this arm has 2 joints)"),
        ("t,tau1,pos,angle", 1, "the header must name them exactly: t, q1, tau1 (this arm has 1 joint)"),  # either
    ],
)
def test_columns_that_are_probably_meant_are_told(tmp_path: Path, header: str, n: int, does: str) -> None:
    with pytest.raises(InputError) as caught:
        load_lines(tmp_path, [header, *("0," * header.count(",") + "0" for _ in range(20))], n)
    assert caught.value.do.startswith(does)


@pytest.mark.parametrize("suffix", FORMATS)
def test_rows_written_twice_are_left_out(tmp_path: Path, suffix: str) -> None:
    run = a_run()
    noted = dataclasses.replace(run, extra=pa.table({"note": [f"row {i}" for i in range(40)]}))
    path = tmp_path / f"a{suffix}"
    save_run(noted, path)
    lines = [0, 1, 2, 2, 2, *range(3, 40), 39]
    if suffix == ".csv":
        text = path.read_text().splitlines()
        path.write_text("\n".join([text[0], *(text[1 + i] for i in lines)]) + "\n")
    else:
        pq.write_table(pq.read_table(path).take(pa.array(lines)), path)
    found = load_run(path, 2)
    assert np.array_equal(found.t, run.t)
    assert np.array_equal(found.temperature, run.temperature)
    assert found.extra.column("note").to_pylist() == noted.extra.column("note").to_pylist()
    assert "rows that repeat the one before in every column, left out: 3" in found.warnings


@pytest.mark.parametrize(
    ("second", "says"),
    [
        ("0.06,0.6,3.001,a", "row 10 repeats the time of the row before"),
        ("0.06,0.600,3.000,b", "row 10 repeats the time of the row before"),  # a column that is not used
        ("0.05,0.600,3.000,a", "row 10 goes back in time"),
    ],
)
def test_rows_that_contradict_are_refused_by_their_row(tmp_path: Path, second: str, says: str) -> None:
    head, *rows = csv_rows()
    lines = [f"{head},note", *(f"{row},a" for row in rows)]
    lines = [*lines[:3], lines[2], *lines[3:8], second, *lines[8:]]
    with pytest.raises(InputError, match=says):
        load_lines(tmp_path, lines)


def test_fault_far_down_a_long_file_keeps_its_row(tmp_path: Path) -> None:
    lines = ["t,q1,tau1", *(f"{i},0.123456789012345678,0.123456789012345678" for i in range(60_000))]
    lines[50_001] = "50000,oops,0"  # some blocks into the file
    with pytest.raises(InputError, match="column q1, row 50002: not a number: found 'oops'"):
        load_lines(tmp_path, lines)
    lines[50_001] = "50000,0"
    with pytest.raises(InputError, match="row 50002 must have 3 values"):
        load_lines(tmp_path, lines)


def test_a_row_of_names_may_be_long(tmp_path: Path) -> None:
    """Of a logger of everything: what it lists last is read as well."""
    more = 1000
    lines = [",".join(["t", *(f"{i:0200}" for i in range(more)), "tau1", "q1"])]
    lines += [f"{0.01 * i}{',' * (more + 1)}1,{i}" for i in range(16)]
    assert len(lines[0]) > 200_000
    run = load_lines(tmp_path, lines)
    assert run.q[:, 0].tolist() == list(range(16))
    assert run.extra is not None
    assert run.extra.num_columns == more


@pytest.mark.parametrize(
    ("content", "says"),
    [
        (b"", "the file is empty"),
        (b"\n\n", "the file is empty"),
        (b"t,q1,tau1\n", "too few samples: found 0"),
        (b"t,q1,tau1\n0,0,0\n", "too few samples: found 1"),
        (b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR", "is not a CSV file: found binary data"),
        (b"PAR1\x15\x04", "is not a CSV file: found Parquet"),
        ("t,q1,tau1\n".encode("utf-16"), "is not a CSV file"),
        (b"t,q1,tau1,Grad \xb0\n", "the header is not text in UTF-8"),
        (b"t,q1,tau1,note\n" + b"0,0,0,\xb0\n" * 20, "invalid UTF8"),
        (b"t,q1,tau1," + b"x" * (1 << 20), "run.csv: row 1 is longer than 1 MiB; give a CSV file"),
        (b"t,q1,tau1," + b"x" * (1 << 18), "run.csv: row 1 is no row of names: found field larger than field limit"),
        (b"t,q1,tau1,q1\n0,0,0,0\n", "two columns have the same name: found 'q1'"),
    ],
)
def test_files_that_are_no_recording(tmp_path: Path, content: bytes, says: str) -> None:
    path = tmp_path / "run.csv"
    path.write_bytes(content)
    with pytest.raises(InputError, match=says):
        load_run(path, 1)


def test_paths_that_are_no_recording(tmp_path: Path) -> None:
    (tmp_path / "folder.csv").mkdir()
    (tmp_path / "text.parquet").write_text("t,q1,tau1\n")
    os.mkfifo(tmp_path / "pipe.csv")
    for name, says in {
        "missing.csv": "no such file",
        "folder.csv": "is a directory",
        "text.parquet": "Parquet magic bytes",
        "pipe.csv": "not a regular file",
        "run.xlsx": "found .xlsx",
        "run": "found no ending",
    }.items():
        with pytest.raises(InputError, match=says):
            load_run(tmp_path / name, 1)


def test_forbidden_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*args: object) -> None:
        raise PermissionError(13, "Permission denied")

    save_run(a_run(), tmp_path / "run.csv")
    monkeypatch.setattr(Path, "open", refuse)  # a mode of 0 would not stop root
    with pytest.raises(InputError, match="cannot be read: found permission denied"):
        load_run(tmp_path / "run.csv", 2)


def test_number_of_joints(tmp_path: Path) -> None:
    save_run(a_run(), tmp_path / "run.csv")
    with pytest.raises(InputError, match="more joints than the arm, which has 1: found q2, tau2"):
        load_run(tmp_path / "run.csv", 1)
    with pytest.raises(InputError, match="columns missing: q3, tau3: found t, q1"):
        load_run(tmp_path / "run.csv", 3)


@pytest.mark.parametrize(
    ("column", "says"),
    [
        (pa.array(["0.5"] * 7 + ["oops"] + ["1"] * 12), "column q1, row 8: not a number: found 'oops'"),
        (pa.array([0.0] * 3 + [None] + [0.0] * 16), "column q1, row 4: not a finite number: found an empty cell"),
        (pa.array([True] * 20), "column q1, row 1: not a number: found True"),
        (pa.array([[1.0]] * 20), "column q1, row 1: not a number"),
    ],
)
def test_parquet_columns_that_are_no_numbers(tmp_path: Path, column: pa.Array, says: str) -> None:
    pq.write_table(pa.table({"t": 0.1 * np.arange(20), "q1": column, "tau1": np.zeros(20)}), tmp_path / "run.parquet")
    with pytest.raises(InputError, match=says):
        load_run(tmp_path / "run.parquet", 1)


def test_parquet_takes_any_number_type(tmp_path: Path) -> None:
    rows = np.arange(20)
    columns = {"t": (rows / 64).astype(np.float32), "q1": rows, "tau1": rows.astype(np.int8)}
    pq.write_table(pa.table(columns), tmp_path / "run.parquet")
    run = load_run(tmp_path / "run.parquet", 1)
    assert run.q.dtype == run.tau.dtype == run.t.dtype == np.float64
    np.testing.assert_array_equal(np.column_stack([run.t, run.q, run.tau]), rows[:, None] / [64, 1, 1])


@pytest.mark.parametrize(
    "dialect",
    [
        lambda text: text.replace("\n", "\r\n"),
        lambda text: "\ufeff" + text,
        lambda text: text.replace(",", " , "),
        lambda text: text + "\n\n",
        lambda text: text.replace("t,q1,tau1", '"t","q1","tau1"'),
    ],
    ids=["windows", "byte order mark", "spaces", "blank lines", "quotes"],
)
def test_harmless_differences_in_csv(tmp_path: Path, dialect) -> None:  # type: ignore[no-untyped-def]
    (tmp_path / "run.csv").write_bytes(dialect("\n".join(csv_rows()) + "\n").encode("utf-8"))
    np.testing.assert_array_equal(load_run(tmp_path / "run.csv", 1).tau[:, 0], 0.5 * np.arange(20))


def test_doubtful_units_are_warned_of(tmp_path: Path) -> None:
    def warnings(**changes: np.ndarray) -> tuple[str, ...]:
        save_run(dataclasses.replace(a_run(400), **changes), tmp_path / "run.csv")
        return load_run(tmp_path / "run.csv", 2).warnings

    run = a_run(400)
    assert run.dq is not None
    assert warnings() == ()
    in_degrees = warnings(q=np.rad2deg(run.q))
    assert any("q1 reaches 57.2" in text and "degrees" in text for text in in_degrees)
    assert any("q2 changes 57.3 times as fast as dq2 says: one of them in degrees?" in text for text in in_degrees)
    (wrong_sign,) = warnings(dq=run.dq * [1, -1])
    assert wrong_sign.startswith("q2 changes -1 times as fast as dq2 says: check units and signs")
    assert warnings(q=run.q % (2.0 * np.pi)) == ()  # a counter that begins its turn anew
    assert warnings(q=run.q * 0.01, dq=0 * run.dq) == ()  # a joint that hardly moves proves nothing


def test_a_straight_axis_is_told_in_its_own_units(tmp_path: Path) -> None:
    run, kinds = a_run(400), ("revolute", "prismatic")
    save_run(dataclasses.replace(run, q=run.q * [1, 1e3]), tmp_path / "run.csv")
    reaches, changes = load_run(tmp_path / "run.csv", 2, kinds).warnings
    assert reaches == f"q2 reaches {1e3 * np.abs(run.q[:, 1]).max():g} m: are these mm?"
    assert changes.endswith(" times as fast as dq2 says: one of them in mm?")
    assert load_runs([tmp_path / "run.csv"], 2, kinds)[0].warnings == (reaches, changes)
    save_run(dataclasses.replace(run, q=run.q * [1, 1e6]), tmp_path / "run.csv")
    with pytest.raises(InputError, match=r"column q2 is beyond 1000 m: found .*; give it in m$"):
        load_run(tmp_path / "run.csv", 2, kinds)


def test_a_name_that_no_file_has(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"cannot be read: found .*x00\.csv'; give the path"):
        load_run(tmp_path / "\0.csv", 2)


def test_times_in_milliseconds_are_refused(tmp_path: Path) -> None:
    """Simulated on over hours that never were, they would take as long."""
    save_run(dataclasses.replace(a_run(400), t=1e3 * a_run(400).t), tmp_path / "run.csv")
    with pytest.raises(InputError, match=r"column t has a median step above 0\.2 s.*give t in seconds"):
        load_run(tmp_path / "run.csv", 2)


@pytest.mark.parametrize("unit", [60.0, 3600.0])
def test_times_in_minutes_or_hours_are_refused(tmp_path: Path, unit: float) -> None:
    run = a_run(400)
    save_run(dataclasses.replace(run, t=1e-3 * np.arange(400) / unit), tmp_path / "run.csv")
    with pytest.raises(InputError, match=r"column t has a median step under 2e-05 s.*not in minutes or hours"):
        load_run(tmp_path / "run.csv", 2)


@pytest.mark.parametrize(("column", "says"), [("t", r"column t is beyond 1e\+11 s"), ("dq", r"column dq2 is beyond")])
def test_numbers_that_no_clock_or_motor_reaches_are_refused(tmp_path: Path, column: str, says: str) -> None:
    """Their squares would be beyond all numbers."""
    run = a_run(400)
    values = np.array(getattr(run, column))
    values.flat[-1] = 1e300
    save_run(dataclasses.replace(run, **{column: values}), tmp_path / "run.csv")
    with pytest.raises(InputError, match=rf"{says}.*: found 1e\+300; give "):
        load_run(tmp_path / "run.csv", 2)


def test_shapes_must_agree() -> None:
    run = a_run()
    with pytest.raises(StribeckError, match=r"tau must have shape \(40, 2\): found \(39, 2\)"):
        dataclasses.replace(run, tau=run.tau[1:])


@pytest.mark.parametrize(
    ("paths", "names"),
    [
        ("a/run.csv b/other.csv", "run.csv other.csv"),
        ("a/run.csv b/run.csv", "a/run.csv b/run.csv"),
        ("run.csv a/../b/run.csv a/other.csv", "{here}/run.csv b/run.csv a/other.csv"),
        ("a/x/run.csv b/x/run.csv", "a/x/run.csv b/x/run.csv"),
    ],
)
def test_names_tell_runs_apart(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, paths: str, names: str) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a").mkdir()
    for path in paths.split():
        save_run(a_run(), path)
    runs = load_runs(paths.split(), 2)
    assert [run.name for run in runs] == names.format(here=tmp_path.name).split()
    assert load_runs([], 2) == []


def test_runs_of_one_name_are_refused() -> None:
    with pytest.raises(InputError, match="two runs have the same name: found a; give each run a name of its own"):
        check_apart([a_run(), a_run(50)])


def test_a_run_that_is_there_twice_is_refused() -> None:
    """Whatever its name and its clock say."""
    run = a_run()
    copy = dataclasses.replace(run, name="b", t=run.t + 9.0)
    with pytest.raises(InputError, match="a run is given twice: found a and b; give each recording once"):
        check_apart([run, dataclasses.replace(run, name="c", q=run.q + 1e-6), copy])


@pytest.mark.skipif(not REAL.exists(), reason="the real recordings do not come with the package")
def test_real_recordings_load() -> None:
    paths = sorted(REAL.glob("*/run_*.csv"))
    assert len(paths) == 9
    for path in paths:
        run = load_run(path, 2)
        assert run.warnings == ()
        assert (run.tau_meas is not None) == ("design-C.1" in str(path))
        assert (np.diff(run.t) > 0).all()


def test_of_a_clock_that_was_set_back_the_rows_are_not_to_be_sorted(tmp_path: Path) -> None:
    """Sorted, rows of before and after would lie between one another."""
    t = 0.01 * np.arange(60)
    t[30:] -= 0.105
    save_run(Run("r", t, np.sin(t)[:, None], np.cos(t)[:, None]), tmp_path / "run.csv")
    with pytest.raises(InputError, match=r"row 32 goes back in time.*split the recording there if its clock was set"):
        load_run(tmp_path / "run.csv", 1)
