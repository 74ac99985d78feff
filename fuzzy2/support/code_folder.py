"""The folder for machine code, which belongs to the user and to which nobody else can write.

Code in this folder is executed. So a folder is only used if nobody else can put a file or a link
into it: it and all folders above it belong to the user or the system, and are either not writable
by others or sticky like the temporary directory. The folder in ``NUMBA_CACHE_DIR`` is used without
this check, because the user chose it.

Each folder of sources has its own subfolder, named after its path, so that two versions or copies
of the packages do not interfere.
"""

from __future__ import annotations

import hashlib
import os
import stat
import tempfile
from functools import lru_cache
from pathlib import Path

from fuzzy2.support.logs import logger_named

NAME = "psp3"

logger = logger_named(__name__)


def code_folder() -> Path | None:
    """Return the existing, writable folder; None if there is none.

    It is that of ``NUMBA_CACHE_DIR``, or ``psp3`` in the user's cache (``XDG_CACHE_HOME``, or
    ``.cache`` in the home folder), or a private folder in the temporary directory, with a log
    message.
    """
    chosen = os.environ.get("NUMBA_CACHE_DIR", "")
    caches = os.environ.get("XDG_CACHE_HOME", "")
    # The standard says that a relative path must be ignored.
    if not os.path.isabs(caches):
        caches = os.path.expanduser("~/.cache")
    return _first_that_serves(chosen, Path(caches), Path(tempfile.gettempdir()))


@lru_cache(maxsize=8)
def _first_that_serves(chosen: str, caches: Path, temporary: Path) -> Path | None:
    if chosen and _is_writable(Path(chosen)):
        return Path(chosen)
    kept, instead = caches / NAME, temporary / f"{NAME}-{os.getuid()}"
    # A link that others made is not private.
    if caches.is_absolute() and _is_writable(kept) and is_private(kept):
        return kept
    why = f"compiled code cannot be kept in {kept}, or others could change it there"
    if _is_writable(instead) and is_private(instead):
        logger.warning("%s; it is kept in %s, unless NUMBA_CACHE_DIR names a folder", why, instead)
        return instead
    logger.warning("%s; each process compiles it again, unless NUMBA_CACHE_DIR names a folder", why)
    return None


def name_for(sources: Path) -> str:
    """Return the name of the subfolder for the code of a folder of sources."""
    return f"{sources.name}-{hashlib.sha256(os.fsencode(sources)).hexdigest()[:20]}"


def forget_code(*packages: Path) -> None:
    """Remove the code of all modules of packages, also of earlier versions in that place.

    Parameters
    ----------
    *packages : Path
        Folders of the packages.
    """
    root = code_folder()
    if root is None:
        return
    for package in packages:
        for sources in {path.parent for path in package.absolute().rglob("*.py")}:
            for kept in (root / name_for(sources)).glob("*.nb[ci]"):
                kept.unlink(missing_ok=True)


def _is_writable(folder: Path) -> bool:
    """Make a folder that only the user can enter, and return whether files can be written to it."""
    try:
        folder.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        folder.mkdir(mode=0o700, exist_ok=True)
        tempfile.TemporaryFile(dir=folder).close()
    except OSError:
        return False
    return True


def is_private(folder: Path) -> bool:
    """Return whether only the user and the system can put anything into a folder.

    Parameters
    ----------
    folder : Path
        The folder, which is not a link; folders above it may be links.
    """
    try:
        own = folder.lstat()
        above = [one.stat() for one in folder.resolve(strict=True).parents]
    except OSError:
        return False
    if not stat.S_ISDIR(own.st_mode) or own.st_uid != os.getuid() or _is_open(own):
        return False
    return all(
        one.st_uid in (0, own.st_uid) and (not _is_open(one) or one.st_mode & stat.S_ISVTX)
        for one in above
    )


def _is_open(found: os.stat_result) -> bool:
    """Return whether others can write to a folder; the user's own group does not count."""
    if found.st_mode & stat.S_IWOTH:
        return True
    return bool(found.st_mode & stat.S_IWGRP) and not _is_own_group(found.st_gid)


def _is_own_group(group: int) -> bool:
    import grp
    import pwd

    if group == 0 and os.getuid() == 0:
        return True
    try:
        user, known = pwd.getpwuid(os.getuid()), grp.getgrgid(group)
    except KeyError:
        return False
    return known.gr_name == user.pw_name and set(known.gr_mem) <= {user.pw_name}
