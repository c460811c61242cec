"""The sources under the sanitizers, any call in any order; no growth; the time that a step takes."""

import ctypes
import resource
import subprocess
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from stribeck.arm import Arm
from stribeck.effects.registry import registry
from stribeck.export.batch import simulate_batch
from stribeck.export.controller.export import describe as describe_controller
from stribeck.export.export import describe
from stribeck.simulate import Compensation, JointLoop, Loop, Reference

from .conftest import two_links
from .driver import OK, Fmu
from .test_effects import MIXED, with_effects

HERE = Path(__file__).parent
SINE = Reference("sine", amplitude=0.1, frequency=1.0)
STEPS = Reference("steps", times=(0.0, 0.5, 1.0), values=(0.0, 0.1, -0.1))
LOOP = Loop(
    joints=(
        JointLoop("A", 900.0, compensation=Compensation("adaptive"), reference=STEPS),
        JointLoop("B", 300.0, velocity="true", delay_samples=2, reference=SINE),
    ),
    duration=2.0,
    sample_time=0.005,
)  # fmt: skip


def sources_of(kind: str, fmi: int) -> dict[str, str]:
    if kind == "controller":
        return describe_controller(two_links(), LOOP, fmi)[1]
    arm = two_links() if kind == "nominal" else with_effects(*[registry()[name] for name in MIXED])
    return describe(arm, fmi)[2]


@pytest.mark.slow
@pytest.mark.parametrize("fmi", [2, 3])
@pytest.mark.parametrize("kind", ["nominal", "mixed", "controller"])
def test_ten_thousand_wild_runs(fmi: int, kind: str, tmp_path: Path) -> None:
    (tmp_path / "sources").mkdir()
    for name, text in sources_of(kind, fmi).items():
        (tmp_path / "sources" / name).write_text(text)
    flags = [
        "-std=gnu99",
        "-O1",
        "-g",
        "-w",
        "-fsanitize=address,undefined",
        "-fno-sanitize-recover=all",
        f"-DFMI_VERSION={fmi}",
    ]
    program = tmp_path / "fuzz"
    build = ["gcc", *flags, f"-I{tmp_path / 'sources'}", "-o", str(program), str(HERE / "fuzz.c"), "-lm"]
    subprocess.run(build, check=True, timeout=300)
    runs = "300" if kind == "mixed" else "10000"
    done = subprocess.run([str(program), runs, "7"], capture_output=True, text=True, timeout=900, check=False)
    assert done.returncode == 0, done.stderr[:3000]
    accepted, refused = int(done.stdout.split()[0]), int(done.stdout.split()[2])
    assert min(accepted, refused) > 10 * int(runs)


def test_ten_thousand_instances_do_not_grow(nominal: Fmu) -> None:
    it = nominal.instance()
    first, more = None, 0
    for i in range(10_000):
        other = nominal.instance(log_on=False)
        other.free()
        if i == 1000:
            first = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    more = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - first
    it.free()
    assert more < 2000  # kB; 9000 instances that stayed would take more than 20 MB


@pytest.mark.slow
def test_speed_of_a_step(made: Callable[[Arm, int], Path], tmp_path: Path) -> None:
    """1 ms steps under a constant command, sliding, against a step that does nothing, by CPU time."""
    library = tmp_path / "speed.so"
    subprocess.run(
        ["gcc", "-O2", "-shared", "-fPIC", "-o", str(library), str(HERE / "speed.c")], check=True, timeout=60
    )
    speed = ctypes.CDLL(str(library))
    speed.timed.restype = ctypes.c_double
    fmu = Fmu(made(two_links(), 2))
    step, h, count = ctypes.cast(fmu.library.fmi2DoStep, ctypes.c_void_p), ctypes.c_double(1e-3), ctypes.c_long(5000)
    idle = ctypes.c_double()
    empty, own = [], []
    for _ in range(20):
        it = fmu.instance().begin({"tau[1]": 9.0, "tau[2]": 4.0, "dq_start[1]": 0.5, "dq_start[2]": 0.5})
        assert it.step(0.0, 1e-3) == OK
        zero = ctypes.c_double(0.0)
        empty.append(speed.timed(speed.idle_step, ctypes.byref(idle), zero, h, count))
        own.append(speed.timed(step, ctypes.c_void_p(it.c), ctypes.c_double(1e-3), h, count))
        it.free()
    print(f"empty step {min(empty):.1f} ns, step of 1 ms {min(own):.1f} ns")
    assert min(own) > 0.0
    assert min(own) - min(empty) < 1500.0


@pytest.mark.slow
def test_ten_thousand_simulations(made: Callable[[Arm, int], Path]) -> None:
    """Of 5 s at 10 ms, in 20 s of CPU time: ten seconds on two cores that nobody else uses."""
    import time

    times = 0.01 * np.arange(501)
    command = np.stack([11.0 * np.sin(2.6 * times) + 4.0 * np.sin(9.0 * times), 3.6 * np.sin(3.7 * times)], axis=1)
    mass = 4.0 * (1.0 + 0.05 * np.random.default_rng(0).standard_normal(10_000))
    names = {"inputs": ["tau[1]", "tau[2]"], "outputs": ["q[1]", "q[2]"]}
    path = made(two_links(), 2)
    simulate_batch(path, times[:2], command[:2], {"joint[1].mass": mass[:2]}, **names)
    start, wall = time.process_time(), time.perf_counter()
    found = simulate_batch(path, times, command, {"joint[1].mass": mass}, jobs=2, **names)
    used, wall = time.process_time() - start, time.perf_counter() - wall
    print(f"{used:.1f} s of CPU time, {wall:.1f} s")
    assert (found.reached == 501).all()
    assert used < 20.0
