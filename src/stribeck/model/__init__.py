"""The signal path, symbolic: rigid body, Tustin friction, and their composition with effects."""
