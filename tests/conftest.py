"""Shared fixtures."""

import os
import tempfile
from pathlib import Path

import pytest

from hairpipe.graph.code import CodeReader
from hairpipe.graph.machine_code import kernel_folder

# Tests, too, must never run old machine code of a helper that was edited.
_KERNELS = Path(tempfile.gettempdir()) / f"hairpipe-kernels-{os.getuid()}"
os.environ["NUMBA_CACHE_DIR"] = str(kernel_folder(_KERNELS, CodeReader(lambda name, make: make())))

SHARED = Path(__file__).resolve().parents[2] / "shared" / "data"


@pytest.fixture(scope="session")
def shared() -> Path:
    """Give the folder of third-party test data that lies beside the checkout and is not shipped."""
    if not SHARED.is_dir():
        pytest.skip("third-party test data absent: no ../shared/data beside the checkout")
    return SHARED
