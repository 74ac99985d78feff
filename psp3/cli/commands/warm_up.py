"""The command that compiles all kernels in advance."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from contextlib import contextmanager

from psp3.cli.output import say


def warm_up() -> None:
    """Compile all kernels now, once, in a few minutes; other commands then start faster.

    The compiled code is kept in the user's cache folder, or in the folder that NUMBA_CACHE_DIR
    names.
    """
    from fuzzy2.support.code_folder import code_folder
    from psp3.warm_up import warm_up as compile_all

    with _progress_said():
        compile_all()
    folder = code_folder()
    say("nothing could be kept" if folder is None else folder)


@contextmanager
def _progress_said() -> Iterator[None]:
    """Report on standard error what is compiled next."""

    class Sayer(logging.Handler):
        def emit(self, record: logging.LogRecord) -> None:
            say(record.getMessage(), err=True)

    logger, sayer = logging.getLogger("psp3.warm_up"), Sayer(logging.INFO)
    before = logger.level, logger.propagate
    logger.setLevel(logging.INFO)
    logger.addHandler(sayer)
    logger.propagate = False
    try:
        yield
    finally:
        logger.removeHandler(sayer)
        logger.level, logger.propagate = before
