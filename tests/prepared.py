"""What the server of :mod:`tests.processes` has done before it forks anything.

Everything that a test's process needs is imported, and every kernel has been called once.
"""

import importlib
import math
import pkgutil

import fuzzy2
import psp3
from fuzzy2.support import announcements
from psp3.warm_up import warm_up

for package in (psp3, fuzzy2):
    for module in pkgutil.walk_packages(package.__path__, f"{package.__name__}."):
        importlib.import_module(module.name)

for name in (
    "IPython.core.interactiveshell",
    "distributed",
    "ipywidgets",
    "matplotlib.pyplot",
    "matplotlib_inline.backend_inline",
    "scipy.integrate",
    "scipy.optimize",
    "tests.study_helpers",
):
    importlib.import_module(name)

# Whether something has been compiled before is no property of what a test starts.
announcements.TOLD = math.inf

warm_up()
