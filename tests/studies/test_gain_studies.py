import importlib
import json

import pytest


@pytest.mark.slow
def test_gains(tmp_path):
    importlib.import_module("gains").main(cases=6)
    result = json.loads((tmp_path / "out/gains/result.json").read_text(encoding="utf-8"))
    known = {"no delay": (3150, 655), "1 sample": (662, 150), "2 samples": (290, 66), "1 sample, lag 20 ms": (283, 57)}
    for name, (stability, ms2) in known.items():
        row = result[name]
        assert (row["stability"], row["ms2"]) == pytest.approx((stability, ms2), rel=0.01)
        assert row["decays_below"]
        assert row["grows_above"]


@pytest.mark.slow
def test_describing_function(tmp_path):
    importlib.import_module("describing_function").main(cases=12)
    result = json.loads((tmp_path / "out/describing_function/result.json").read_text(encoding="utf-8"))
    assert result["coulomb"]["0.5"]["df_amplitude"] == pytest.approx(-0.084, abs=2e-3)
    assert result["coulomb"]["0.9"]["df_period"] == pytest.approx(-0.564, abs=2e-3)
    assert abs(result["coulomb"]["0.7"]["hb_period"]) < 1e-3
    assert result["hunting"]["cycles"] == 9
    assert result["hunting"]["df_found"] == 0
