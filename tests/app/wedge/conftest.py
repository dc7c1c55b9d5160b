"""The toy shot of the command line."""

from ..cli.conftest import shot  # noqa: F401
