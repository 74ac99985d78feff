"""Computed torque with M, C and G learned by fuzzy systems: training, adaptation and monitoring."""
