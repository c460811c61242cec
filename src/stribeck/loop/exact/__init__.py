"""Exact limit cycles: event-accurate rounds, shooting, settling, continuation, critical ratios."""
