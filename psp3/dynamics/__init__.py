"""Dynamics beyond the robot's own: natural orthogonal complement, derivatives, linearization."""
