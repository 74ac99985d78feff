"""Export of C99 code: fuzzy systems, and any kernels that follow ``docs/concepts/kernels.md``."""
