"""The version, in its own module so that it can be imported without the facade."""

__version__ = "0.2.0"
