"""Friction in robot arms and the gap between a simulated arm and the recorded one."""
