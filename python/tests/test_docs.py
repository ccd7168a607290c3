"""Runs the examples of the pages on Python."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


@pytest.mark.parametrize("page", ["python/README.md", "docs/python.md"])
def test_examples_run(page: str) -> None:
    for package in ("dask.array", "geopandas", "matplotlib", "xarray"):
        pytest.importorskip(package)
    blocks = re.findall(
        r"^```python\n(.*?)^```", (ROOT / page).read_text(), re.DOTALL | re.MULTILINE
    )
    assert len(blocks) > 2
    names: dict[str, object] = {}
    for block in blocks:
        exec(compile(block, page, "exec"), names)
