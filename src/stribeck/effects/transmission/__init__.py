"""Effects of the transmission channel, one file each."""
