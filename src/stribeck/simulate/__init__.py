"""Event-accurate simulation with true stiction: the compiled engine, prediction and the control loop."""
