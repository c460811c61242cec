"""Models fitted to recordings: their residuals, how noise comes through them, and the arms that they stand for."""
