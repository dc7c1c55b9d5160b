"""Shared fixtures."""

from pathlib import Path

import pytest

SHARED = Path(__file__).resolve().parents[2] / "shared" / "data"


@pytest.fixture(scope="session")
def shared() -> Path:
    """The folder of third-party test data that lies beside the checkout and is not shipped."""
    if not SHARED.is_dir():
        pytest.skip("third-party test data absent: no ../shared/data beside the checkout")
    return SHARED
