"""Fixed seeds, and what is skipped where it cannot run.

The seeds of the property tests are fixed: a failure today is a failure tomorrow.
"""

from pathlib import Path

import pytest
from hypothesis import settings

settings.register_profile("isoembed", derandomize=True, deadline=None, max_examples=30)
settings.load_profile("isoembed")

SHARED = Path(__file__).parents[2] / "shared"


def pytest_collection_modifyitems(items):
    """Skip the tests that are marked ``shared`` where there is no such folder."""
    if SHARED.is_dir():
        return
    for item in items:
        if item.get_closest_marker("shared"):
            item.add_marker(pytest.mark.skip(reason="there is no folder ../shared beside the project"))
