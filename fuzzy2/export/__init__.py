"""C99 code: of fuzzy systems, and of any kernels that keep to ``docs/concepts/kernels.md``."""
