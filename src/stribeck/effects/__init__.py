"""The library of effects: one file each, and the registry that lists them."""
