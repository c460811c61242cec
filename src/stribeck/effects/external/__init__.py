"""Effects of the external channel, one file each."""
