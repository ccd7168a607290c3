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


def check(converged: bool, report: Mapping[str, object], strict: bool) -> None:
    """Warn or raise if a computation has not converged."""
    if converged:
        return
    text = (
        f"not converged after {report['iterations']} iterations: the last one changed distances "
        f"by a fraction of {report['residual']:.1e}; give more iterations or a larger tolerance"
    )
    if strict:
        raise ConvergenceError(text)
    warnings.warn(text, ConvergenceWarning, stacklevel=4)
