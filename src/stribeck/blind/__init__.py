"""The withheld check: diagnose sealed cases without their answers, then score what was said against the key."""
