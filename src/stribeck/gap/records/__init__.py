"""Recordings made ready: one clock, one order, one cutoff, their noise, and what they show before any model."""
