"""Robot description files: URDF, SRDF, loop files and MJCF, read and checked before Pinocchio sees them."""
