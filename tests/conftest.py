"""Fixed seeds, and what is skipped where it cannot run.

The seeds of the property tests are fixed: a failure today is a failure tomorrow.
"""

import os
import signal

import pytest
from hypothesis import HealthCheck, settings

from places import SHARED

settings.register_profile(
    "isoembed",
    derandomize=True,
    deadline=None,
    suppress_health_check=[HealthCheck.too_slow],  # it asks a clock, and a machine may be busy
    max_examples=30,
)
settings.load_profile("isoembed")


@pytest.fixture(scope="session", autouse=True)
def interruptible():
    """Ctrl-C as usual, also where the tests were started with SIGINT ignored, as background jobs are."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.fixture(scope="session", autouse=True)
def unsynced():
    """Files of tests need not survive a power failure: some disks take milliseconds for each."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(os, "fsync", lambda file: None)
        yield


def pytest_collection_modifyitems(items):
    """Skip the tests that are marked ``shared`` where there is no such folder."""
    if SHARED.is_dir():
        return
    for item in items:
        if item.get_closest_marker("shared"):
            item.add_marker(pytest.mark.skip(reason="there is no folder ../shared beside the project"))
