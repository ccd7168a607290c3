"""Packages that some functions need and `pip install geosweep` leaves out."""

import importlib
from typing import Any


def needed(module: str, extra: str, purpose: str) -> Any:
    """Import a module, or raise ImportError that names the extra which brings it."""
    try:
        return importlib.import_module(module)
    except ImportError as error:
        raise ImportError(
            f"{purpose} needs {module.partition('.')[0]}: pip install 'geosweep[{extra}]'"
        ) from error
