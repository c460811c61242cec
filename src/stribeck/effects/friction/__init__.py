"""Effects of the friction channel, one file each."""
