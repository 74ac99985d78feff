"""Files of fuzzy systems: JSON, .fis and FML."""
