"""The repository of recorded figures."""

from ...figures.conftest import repository  # noqa: F401
