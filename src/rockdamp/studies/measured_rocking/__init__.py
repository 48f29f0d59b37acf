"""Measured free rocking: which damping model the ratios of 134 trials support, and how they scatter."""
