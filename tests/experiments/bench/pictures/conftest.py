"""The toy shot of the engine's tests."""

from ....graph.conftest import shot, trusted  # noqa: F401
