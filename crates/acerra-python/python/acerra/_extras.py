"""Packages that some functions need, installed with an extra of this one."""

from __future__ import annotations

import importlib
from typing import Any


def needed(module: str, extra: str, user: str) -> Any:
    """A module of another package.

    Parameters
    ----------
    module : str
        Name of the module.
    extra : str
        The extra of this package that brings it.
    user : str
        What needs it.

    Raises
    ------
    ImportError
        With the command that installs it.
    """
    try:
        return importlib.import_module(module)
    except ImportError as error:
        package = module.partition(".")[0]
        raise ImportError(
            f"{user}: expected the package {package}, which is not installed; "
            f"pip install 'acerra[{extra}]'"
        ) from error
