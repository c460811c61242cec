"""Run an arm's FMU in FMPy: python with_fmpy.py MODEL.fmu input.csv output.csv [CoSimulation|ModelExchange]."""

import sys

import numpy as np
from fmpy import simulate_fmu

fmu, given, out = sys.argv[1:4]
kind = sys.argv[4] if len(sys.argv) > 4 else "CoSimulation"
table = np.genfromtxt(given, delimiter=",", names=True)
n = len(table.dtype.names) - 1
# each torque is held to the next row: two rows at every instant but the first tell FMPy so
rows = np.repeat(np.arange(len(table)), 2)
held = np.zeros(len(rows) - 1, dtype=[("time", float), *((f"tau[{k + 1}]", float) for k in range(n))])
held["time"] = table["t"][rows[1:]]
for k in range(n):
    held[f"tau[{k + 1}]"] = table[f"tau{k + 1}"][rows[:-1]]
step = table["t"][1] - table["t"][0]
tolerance = 1e-9 if kind == "ModelExchange" else 1e-8  # CVode's errors add up to 100 times that and more
result = simulate_fmu(
    fmu, fmi_type=kind, stop_time=table["t"][-1], output_interval=step, relative_tolerance=tolerance, input=held,
    output=[f"q[{k + 1}]" for k in range(n)], record_events=False, timeout=300,
)  # fmt: skip
columns = np.column_stack([result["time"], *(result[f"q[{k + 1}]"] for k in range(n))])
np.savetxt(out, columns, "%.17g", ",", header=",".join(["t", *(f"q{k + 1}" for k in range(n))]), comments="")
