"""The dynamics of any tree with loops, compiled: one core for all robots."""
