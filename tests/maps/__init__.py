"""The thesis's equations: each has a function and a test."""
