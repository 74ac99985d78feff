"""What follows from the equation of motion: the natural orthogonal complement, derivatives, linearization."""
