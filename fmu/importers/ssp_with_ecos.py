"""Run arm and controllers, coupled in an SSP file, in Ecos: python ssp_with_ecos.py loop.ssp STEP STEPS output.csv."""

import sys

import numpy as np
from ecospy import EcosSimulation

ssp, step, steps, out = sys.argv[1], float(sys.argv[2]), int(sys.argv[3]), sys.argv[4]
rows = []
with EcosSimulation(ssp_path=ssp, step_size=step) as simulation:
    simulation.init()
    for i in range(steps + 1):
        rows.append([i * step, simulation.get_real("arm::q[1]"), simulation.get_real("arm::q[2]")])
        simulation.step()
    simulation.terminate()
np.savetxt(out, rows, "%.17g", ",", header="t,q1,q2", comments="")
