"""Files of fuzzy systems: JSON, .fis, FML, .fll and .fcl."""
