"""What all of fuzzy2 uses: checks of arguments, compilation, files, quadrature, lazy names."""
