"""Comparisons of psp3 with other engines and with robots it was not written for."""
