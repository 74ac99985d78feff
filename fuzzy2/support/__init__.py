"""What all of fuzzy2 stands on: checks of arguments, compilation, files, quadrature, lazy names."""
