"""Motors: inertia, friction and screws."""

from __future__ import annotations

from typing import TYPE_CHECKING

from fuzzy2.support.lazy import lazy_names

if TYPE_CHECKING:
    from psp3.drives.drive import NO_DRIVE as NO_DRIVE
    from psp3.drives.drive import Drive as Drive
    from psp3.drives.drive import drive_table as drive_table

__all__, __getattr__, __dir__ = lazy_names(__name__)
