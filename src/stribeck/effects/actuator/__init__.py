"""Effects of the actuator channel, one file each."""
