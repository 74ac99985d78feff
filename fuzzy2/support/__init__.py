"""Common tools of fuzzy2: argument checks, compilation, files, quadrature, lazy imports."""
