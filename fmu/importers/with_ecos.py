"""Run an arm's FMU in Ecos: python with_ecos.py MODEL.fmu input.csv output.csv.

Needs ``pip install ecospy`` and, on Debian, ``apt install libtbb12``.
"""

import sys

import numpy as np
from ecospy import EcosSimulation, EcosSimulationStructure

fmu, given, out = sys.argv[1:4]
table = np.genfromtxt(given, delimiter=",", names=True)
n = len(table.dtype.names) - 1
step = float(table["t"][1] - table["t"][0])
rows = []
with EcosSimulationStructure() as structure:
    structure.add_model("arm", fmu)
    with EcosSimulation(structure=structure, step_size=step) as simulation:
        simulation.init()
        for i in range(len(table)):
            rows.append([table["t"][i], *(simulation.get_real(f"arm::q[{k + 1}]") for k in range(n))])
            for k in range(n):
                simulation.set_real(f"arm::tau[{k + 1}]", float(table[f"tau{k + 1}"][i]))
            simulation.step()
        simulation.terminate()
np.savetxt(out, rows, "%.17g", ",", header=",".join(["t", *(f"q{k + 1}" for k in range(n))]), comments="")
