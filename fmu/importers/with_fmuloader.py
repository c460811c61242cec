"""Run an arm's FMU in fmuloader: python with_fmuloader.py MODEL.fmu input.csv output.csv."""

import sys
import zipfile
from xml.etree import ElementTree

import numpy as np
from fmuloader.fmi2 import Fmi2Slave, Fmi2Type
from fmuloader.fmi3 import Fmi3Slave

fmu, given, out = sys.argv[1:4]
table = np.genfromtxt(given, delimiter=",", names=True)
n = len(table.dtype.names) - 1
step = float(table["t"][1] - table["t"][0])
with zipfile.ZipFile(fmu) as archive:
    root = ElementTree.fromstring(archive.read("modelDescription.xml"))
numbers = {v.get("name"): int(v.get("valueReference")) for v in root.find("ModelVariables")}
identifier = root.find("CoSimulation").get("modelIdentifier")
tau, q = ([numbers[f"{name}[{k + 1}]"] for k in range(n)] for name in ("tau", "q"))
rows = []
if root.get("fmiVersion") == "2.0":
    slave = Fmi2Slave(fmu, model_identifier=identifier)
    # fmuloader 0.1.2 cuts the pointers that its own allocateMemory returns to 32 bits; the FMU can do without
    slave.instantiate(
        "arm", fmu_type=Fmi2Type.CO_SIMULATION, guid=root.get("guid"), cannot_use_memory_management_functions=True
    )
    slave.setup_experiment(tolerance=1e-8)
    slave.enter_initialization_mode()
    read, write = slave.get_real, slave.set_real
else:
    slave = Fmi3Slave(fmu, model_identifier=identifier)
    slave.instantiate_co_simulation("arm", instantiation_token=root.get("instantiationToken"))
    slave.enter_initialization_mode(tolerance=1e-8)
    read, write = slave.get_float64, slave.set_float64
slave.exit_initialization_mode()
for i in range(len(table)):
    rows.append([table["t"][i], *read(q)])
    write(tau, [float(table[f"tau{k + 1}"][i]) for k in range(n)])
    slave.do_step(float(table["t"][i]), step)
slave.terminate()
slave.free_instance()
np.savetxt(out, rows, "%.17g", ",", header=",".join(["t", *(f"q{k + 1}" for k in range(n))]), comments="")
