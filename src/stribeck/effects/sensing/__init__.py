"""Effects of the sensing channel, one file each."""
