"""Controllers that learn nothing."""
