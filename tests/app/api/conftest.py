"""The toy shot of the command line."""

from ..cli.conftest import computed, failing, result, shot  # noqa: F401
