"""The Modelica experiment in an independent compiler, Rumoca, around an arm written in Modelica: the engine's loop."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from stribeck.arm import Arm, Friction
from stribeck.simulate import Loop, simulate_loop

from .conftest import MODELS, ROOT

CONNECTORS = """
package Modelica
  package Blocks
    package Interfaces
      connector RealInput = input Real;
      connector RealOutput = output Real;
    end Interfaces;
  end Blocks;
end Modelica;
"""
EXPERIMENT = """
model Plant "The two-link arm of fmu/two_link_nominal, its friction viscous: no events"
  extends StribeckArm.Interfaces.Arm(n = 2);
  Real x[2](each start = 0, each fixed = true);
  Real v[2](each start = 0, each fixed = true);
  Real k = 0.7 * (0.13 * cos(x[2]) + 0.01 * sin(x[2]));
  Real slope = -0.7 * (0.13 * sin(x[2]) - 0.01 * cos(x[2]));
equation
  der(x) = v;
  (0.6262 + 2 * k) * der(v[1]) + (0.054 + k) * der(v[2]) + slope * v[2] * (2 * v[1] + v[2])
    = tau[1] - 1.5 * v[1];
  (0.054 + k) * der(v[1]) + 0.134 * der(v[2]) - slope * v[1] * v[1] = tau[2] - 0.8 * v[2];
  q = x;
  dq = v;
end Plant;
model Experiment
  extends StribeckArm.Examples.PaperExperiment(redeclare model ImportedArm = Plant, a(c0 = 0, c1 = 0));
end Experiment;
"""
RUN = """
import json, sys, rumoca
model = rumoca.Session().load(sys.argv[1], model="Experiment")
result = model.simulate(t=(0.0, 5.0), dt=0.0125, config=rumoca.SimConfig(rtol=1e-10, atol=1e-12))
print(json.dumps([list(map(float, c)) for c in (result.time, result["arm.q[1]"], result["arm.q[2]"], result["a.tau"])]))
"""


@pytest.mark.slow
def test_experiment_is_the_loop(arm: Arm, loop: Loop, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(ROOT / "studies"))
    from _importers import run_other

    package = (MODELS / "StribeckArm.mo").read_text(encoding="utf-8").replace("within ;", "")
    (tmp_path / "all.mo").write_text(CONNECTORS + package + EXPERIMENT, encoding="utf-8")
    (tmp_path / "run.py").write_text(RUN, encoding="utf-8")
    t, *shown = np.array(json.loads(run_other([str(tmp_path / "run.py"), str(tmp_path / "all.mo")])))
    viscous = [Friction(0.0, 0.0, joint.friction.C2, joint.friction.alpha) for joint in arm.joints]
    joints = [replace(joint, friction=f, backward=f) for joint, f in zip(arm.joints, viscous, strict=True)]
    found = simulate_loop(replace(arm, joints=tuple(joints)), loop, tolerance=1e-11)
    rows = np.searchsorted(t, found.motion.t - 1e-9, side="left")  # where a sample has two rows: before it
    for k in (0, 1):
        np.testing.assert_allclose(shown[k][rows], found.measured[:, k], rtol=0.0, atol=1e-7)
    assert np.ptp(found.measured[:, 0]) > 0.1
