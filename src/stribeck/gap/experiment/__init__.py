"""The next experiment: what to record, or to change, so that the candidates that are left come apart."""
