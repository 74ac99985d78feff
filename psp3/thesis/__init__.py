"""The thesis, replicated: chapters, tables, figures, and the report of ``psp3 reproduce``."""
