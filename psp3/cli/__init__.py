"""The command ``psp3``."""
