"""What is tried to harm who uses the packages."""
