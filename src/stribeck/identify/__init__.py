"""Identification: conditioned signals, the residual along recorded motion, and the maximum a posteriori fit."""
