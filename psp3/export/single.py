"""A robot's numbers in single precision: tolerances that its roundings can meet."""

CONSTANTS = {}


def numbers_of(table, title):
    return table.numbers
