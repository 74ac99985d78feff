"""What the server of :mod:`tests.processes` has done before it forks anything.

Everything that a test's process needs is imported, and every kernel has been called once.
"""

import distributed  # noqa: F401
import matplotlib_inline.backend_inline  # noqa: F401

import psp3.cli.entry
import psp3.plots
import psp3.thesis.replication
import psp3.visualize  # noqa: F401
import tests.study_helpers  # noqa: F401
from psp3.warm_up import warm_up

warm_up()
