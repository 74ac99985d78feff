"""Robots in general: any tree with loops, its payloads, and its export to MuJoCo."""
