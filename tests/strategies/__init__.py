"""Robots and fuzzy systems as hypothesis makes them up, with what they can be written as."""
