"""Robot description files: URDF, SRDF, loop files and MJCF, checked before Pinocchio reads them."""
