"""Event-accurate simulation with true stiction: the compiled engine, prediction and the control loop."""

from stribeck.simulate.closed import Closed, close_loop, simulate_loop, simulate_many
from stribeck.simulate.engine import Engine, path_of
from stribeck.simulate.loop import Compensation, JointLoop, Loop, Reference
from stribeck.simulate.loopfile import check_loop, load_loop, read_loop
from stribeck.simulate.motion import Trajectory, Windows
from stribeck.simulate.predict import Prediction, predict, predict_conditioned

__all__ = [
    "Closed", "Compensation", "Engine", "JointLoop", "Loop", "Prediction", "Reference", "Trajectory", "Windows",
    "check_loop", "close_loop", "load_loop", "path_of", "predict", "predict_conditioned", "read_loop", "simulate_loop",
    "simulate_many",
]  # fmt: skip
