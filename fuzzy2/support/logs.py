"""Loggers whose messages cannot control the terminal that shows them."""

from __future__ import annotations

import logging

from fuzzy2.errors import printable


def logger_named(name: str) -> logging.Logger:
    """Return a module's logger, whose messages are printable.

    See :func:`fuzzy2.errors.printable`.
    """
    logger = logging.getLogger(name)
    logger.addFilter(_made_printable)
    return logger


def _made_printable(record: logging.LogRecord) -> bool:
    record.msg, record.args = printable(record.getMessage()), None
    return True
