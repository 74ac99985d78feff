"""A file of MATLAB's Fuzzy Logic Toolbox: read, asked, and written for other programs."""

from pathlib import Path

import numpy as np

import fuzzy2

tipper = fuzzy2.load(Path(__file__).parent / "tipper.fis")
print(tipper.explain([9.0, 3.0]))  # which rules decide there, and how much

services, foods = np.meshgrid([0.0, 5.0, 10.0], [0.0, 5.0, 10.0])
tips = tipper(np.stack([services, foods], axis=-1))[..., 0]  # nine at once
print("food 0, 5, 10 down; service 0, 5, 10 across:")
print(tips.round(2))

for name in ("copy.fis", "tipper.fml", "tipper.json"):
    fuzzy2.save(tipper, name)
    print(name, "answers", fuzzy2.load(name)([5.0, 5.0]).round(4))
