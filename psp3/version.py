"""The version, apart from the facade, so that nothing has to import the facade for it."""

__version__ = "0.2.0"
