"""The command line, as its own tests run it."""

from __future__ import annotations

from tests.psp3.cli.conftest import psp3_command as psp3_command
