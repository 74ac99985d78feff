"""Generators of the robots in this folder: solids, two file formats, one module per robot."""
