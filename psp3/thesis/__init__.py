"""The thesis, replicated: its chapters, tables and figures, and the report of ``psp3 reproduce``."""
