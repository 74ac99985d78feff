"""Files that were changed on purpose, and what the readers of both packages make of them.

``python -m tests.hostile 50000`` (``make fuzz``) tries so many; the tests try a few of each reader.
"""
