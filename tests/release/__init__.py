"""Everything that a release needs short of publishing it: ``make release-check``."""
