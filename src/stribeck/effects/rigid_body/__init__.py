"""Effects of the rigid-body channel, one file each."""
