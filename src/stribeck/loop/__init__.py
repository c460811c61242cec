"""Gain and limit-cycle analysis: approximate methods, and exact ones beside them."""
