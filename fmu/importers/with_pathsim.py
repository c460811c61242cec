"""Run an arm's FMU in PathSim: python with_pathsim.py MODEL.fmu input.csv output.csv [CoSimulation|ModelExchange].

Needs ``pip install pathsim-fmi``. In Model Exchange the torques run straight from row to row: a source that jumps is no
event to PathSim.
"""

import sys

import numpy as np
from pathsim import Connection, Simulation
from pathsim.blocks import Source
from pathsim.solvers import RKDP54
from pathsim_fmi import CoSimulationFMU, ModelExchangeFMU

fmu, given, out = sys.argv[1:4]
exchange = len(sys.argv) > 4 and sys.argv[4] == "ModelExchange"
table = np.genfromtxt(given, delimiter=",", names=True)
n = len(table.dtype.names) - 1
step = float(table["t"][1] - table["t"][0])
held = [table[f"tau{k + 1}"] for k in range(n)]
rows = []


class Recorded(CoSimulationFMU):
    """Keeps what the FMU shows at the end of each of its steps."""

    def _step_fmu(self, t):
        super()._step_fmu(t)
        rows.append([t + self.dt, *self.outputs.to_array()[:n]])


block = ModelExchangeFMU(fmu, tolerance=1e-10) if exchange else Recorded(fmu, dt=step)


def torque(t, k):
    """Return the torque of joint k at a time."""
    if exchange:
        return float(np.interp(t, table["t"], held[k]))
    return held[k][min(int(t / step + 1e-6), len(table) - 1)]


sources = [Source(lambda t, k=k: torque(t, k)) for k in range(n)]
wires = [Connection(source, block[k]) for k, source in enumerate(sources)]
solver = {"Solver": RKDP54, "tolerance_lte_rel": 1e-9, "tolerance_lte_abs": 1e-11} if exchange else {}
simulation = Simulation([*sources, block], wires, dt=step, log=False, **solver)
rows.append([0.0, *block.outputs.to_array()[:n]])
if exchange:
    for t in table["t"][1:]:
        simulation.run(step, reset=False, adaptive=True)
        rows.append([t, *block.outputs.to_array()[:n]])
else:
    simulation.run(float(table["t"][-1]) - step, reset=False, adaptive=False)
rows = rows[: len(table)]
np.savetxt(out, rows, "%.17g", ",", header=",".join(["t", *(f"q{k + 1}" for k in range(n))]), comments="")
