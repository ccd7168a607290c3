"""Warnings and errors about maps."""

import warnings
from collections.abc import Mapping


class ConvergenceWarning(UserWarning):
    """The iterations ran out before the distances had settled."""


class ConvergenceError(RuntimeError):
    """The iterations ran out before the distances had settled, with ``strict=True``."""


class SeamWarning(UserWarning):
    """The surface is closed where the grid ends, and not glued."""


class ScaleWarning(UserWarning):
    """Lengths on a map projection differ from those on the ground."""


class SkewWarning(UserWarning):
    """Cells are so skewed that distances may be late by tens of per cent."""


def check(converged: bool, report: Mapping[str, object], strict: bool) -> None:
    """Warn of cells that are too skewed, and warn or raise if a computation has not converged."""
    if place := report.get("unresolved"):
        warnings.warn(
            f"cells around {place} are so skewed that distances may be late by tens of per cent "
            "there; rows or columns should follow the direction in which lengths are short",
            SkewWarning,
            stacklevel=4,
        )
    if converged:
        return
    text = (
        f"not converged after {report['iterations']} iterations: the last one changed distances "
        f"by a fraction of {report['residual']:.1e}; give more iterations or a larger tolerance"
    )
    if strict:
        raise ConvergenceError(text)
    warnings.warn(text, ConvergenceWarning, stacklevel=4)
