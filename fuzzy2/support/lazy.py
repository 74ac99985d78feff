"""Facades: packages whose public names are imported at their first use.

A facade lists its public names once, as imports for the type checker:

.. code-block:: python

    if TYPE_CHECKING:
        from fuzzy2.numbers.affine import GaussianNumber as GaussianNumber

    __all__, __getattr__, __dir__ = lazy_names(__name__)
"""

from __future__ import annotations

import ast
import importlib
import sys
from collections.abc import Callable, Iterator
from typing import Any


def lazy_names(package: str) -> tuple[list[str], Callable[[str], Any], Callable[[], list[str]]]:
    """Return ``__all__``, ``__getattr__`` and ``__dir__`` of a package.

    They follow from the imports under ``TYPE_CHECKING``.

    Parameters
    ----------
    package : str
        The ``__name__`` of a package that is being imported.

    Returns
    -------
    tuple
        Sorted names, a function that imports the object of a name, and a function that lists the
        names.
    """
    homes = dict(_imported_for_types(package))
    names = sorted(homes)

    def get(name: str) -> Any:
        if name not in homes:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        home = importlib.import_module(homes[name])
        if hasattr(home, "__path__"):  # a package offers its modules
            return importlib.import_module(f"{homes[name]}.{name}")
        return getattr(home, name)

    return names, get, lambda: list(names)


def _imported_for_types(package: str) -> Iterator[tuple[str, str]]:
    """Yield every name that a package imports for the type checker, with its module."""
    # a module that is being imported has a spec
    loader: Any = sys.modules[package].__spec__.loader  # type: ignore[union-attr]
    for statement in ast.parse(loader.get_source(package)).body:
        if isinstance(statement, ast.If) and ast.unparse(statement.test) == "TYPE_CHECKING":
            for found in statement.body:
                if isinstance(found, ast.ImportFrom) and found.module:
                    yield from ((alias.name, found.module) for alias in found.names)
