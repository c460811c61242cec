"""A small master: FMUs through fmpy, no more than the standard's calls."""

from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from fmpy import extract, read_model_description
from fmpy.simulation import instantiate_fmu


class Slave:
    """One Co-Simulation FMU between its initialisation and its end."""

    def __init__(self, fmu: Path, folder: str) -> None:
        extract(str(fmu), folder)
        self.description = read_model_description(folder)
        self.fmu: Any = instantiate_fmu(folder, self.description, "CoSimulation")
        self.numbers = {v.name: v.valueReference for v in self.description.modelVariables}
        self.two = self.description.fmiVersion == "2.0"

    def begin(self, **values: list[float]) -> None:
        if self.two:
            self.fmu.setupExperiment(tolerance=1e-8, startTime=0.0)
        for name, numbers in values.items():
            self.set(name, numbers)
        self.fmu.enterInitializationMode(**({} if self.two else {"tolerance": 1e-8, "startTime": 0.0}))
        self.fmu.exitInitializationMode()

    def references(self, name: str, count: int) -> list[int]:
        return [self.numbers[f"{name}[{k + 1}]"] for k in range(count)]

    def set(self, name: str, values: Any) -> None:
        write = self.fmu.setReal if self.two else self.fmu.setFloat64
        write(self.references(name, len(values)), [float(value) for value in values])

    def get(self, name: str, count: int) -> list[float]:
        read = self.fmu.getReal if self.two else self.fmu.getFloat64
        return list(read(self.references(name, count)))

    def step(self, time: float, step: float) -> None:
        self.fmu.doStep(currentCommunicationPoint=time, communicationStepSize=step)


@contextmanager
def slave(fmu: Path):
    with TemporaryDirectory() as folder:
        opened = Slave(fmu, folder)
        try:
            yield opened
        finally:
            opened.fmu.terminate()
            opened.fmu.freeInstance()
