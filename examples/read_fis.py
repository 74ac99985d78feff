"""A file of MATLAB's Fuzzy Logic Toolbox: read, evaluate, and write it for other programs."""

from pathlib import Path

import numpy as np

import fuzzy2

tipper = fuzzy2.load(Path(__file__).parent / "tipper.fis")
print(tipper.explain([9.0, 3.0]))  # firing rules at this input, and their strengths

services, foods = np.meshgrid([0.0, 5.0, 10.0], [0.0, 5.0, 10.0])
tips = tipper(np.stack([services, foods], axis=-1))[..., 0]  # nine inputs at once
print("food 0, 5, 10 down; service 0, 5, 10 across:")
print(tips.round(2))

for name in ("copy.fis", "tipper.fml", "tipper.json"):
    fuzzy2.save(tipper, name)
    print(name, "answers", fuzzy2.load(name)([5.0, 5.0]).round(4))
