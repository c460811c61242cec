"""The studies of limit cycles: what each answers, asserted on what it wrote."""

import importlib
import json
from pathlib import Path

import pytest


@pytest.fixture
def run(tmp_path: Path):
    """Run a study in this process, writing to a folder of the test; return its result."""

    def study(name: str):
        importlib.import_module(name).main()
        folder = tmp_path / "out" / name
        assert [path.read_bytes()[:4] for path in folder.glob("*.png")] == [b"\x89PNG"]
        return json.loads((folder / "result.json").read_text(encoding="utf-8"))

    return study


@pytest.mark.slow
def test_over_compensation(run):
    """Feedforward never cycles; feedback does over the ratio of its rule, as large as the coth law says."""
    result = run("over_compensation")
    assert set(result["feedforward"]) == {"rest"}
    slow, fast = result["fold_velocity_by_ratio"]
    assert slow == pytest.approx(fast, rel=1e-4)
    assert result["critical_off"] < 2e-5
    assert result["coth_off"] < 1e-7
    known = result["zeta_0.5"]
    assert (known["verdict"], known["amplitude"]) == ("sliding_cycle", pytest.approx(0.0757, rel=1e-3))
    assert result["zeta_1"]["verdict"] == "rest"
    assert result["zeta_1"]["error"] == pytest.approx(-0.3 * 6.25 / 30.0, rel=1e-3)
    assert result["unbounded"]["about"] == ["sliding_cycle", "unbounded"]


def test_hunting(run):
    """Under-compensated PID hunts at every ratio below 1, stuck most of the time; PD rests."""
    result = run("hunting")
    assert result["known"]["verdict"] == "hunting"
    assert result["known"]["amplitude"] == pytest.approx(0.091, rel=5e-3)
    assert result["known"]["stick_fraction"] > 0.5
    assert result["without_integral"]["verdict"] == "rest"
    for verdicts in result["without_stiction"].values():  # of the ratio 0 first; others are off at rest
        assert verdicts[0] == "rest"
        assert set(verdicts[1:]) == {"hunting"}
    for rows in result["branches"].values():
        assert {row["verdict"] for row in rows} == {"hunting"}
        sizes = [row["amplitude"] for row in rows]
        assert sizes == sorted(sizes)


def test_noise_dead_band(run):
    """Noise makes the critically damped, over-compensated loop cycle; a dead-band of 4.4 deviations stops it."""
    result = run("noise_dead_band")
    assert result["without_noise"] == "rest"
    assert result["with_noise"]["verdict"] == "sliding_cycle"
    assert result["with_noise"]["amplitude"] == pytest.approx(0.0609, rel=0.03)
    assert result["with_noise"]["period"] == pytest.approx(3.8, rel=0.06)
    assert result["with_dead_band_5"] == "rest"
    by_band = {row["band"]: row["amplitude"] for row in result["dead_band"]}
    assert all(by_band[band] == 0.0 for band in by_band if band >= 4.4)
    assert all(by_band[band] > 0.05 for band in by_band if band <= 3.0)
