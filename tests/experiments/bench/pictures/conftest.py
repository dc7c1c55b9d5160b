"""The toy shot of the engine's tests."""

from ....engine.conftest import shot, trusted  # noqa: F401
