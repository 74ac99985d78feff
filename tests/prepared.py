"""What the server of :mod:`tests.processes` has done before it forks anything.

Everything that a test's process needs is imported, and every kernel has been called once.
"""

import importlib

from psp3.warm_up import warm_up

for name in (
    "IPython.core.interactiveshell",
    "distributed",
    "matplotlib_inline.backend_inline",
    "psp3.cli.entry",
    "psp3.plots",
    "psp3.thesis.replication",
    "psp3.visualize",
    "tests.study_helpers",
):
    importlib.import_module(name)

warm_up()
