"""How the robots of this folder are made: solids, two kinds of files, one module a robot."""
