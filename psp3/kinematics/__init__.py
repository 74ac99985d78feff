"""Frames, tasks, singularities and workspaces of any robot."""
