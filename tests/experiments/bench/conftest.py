"""The benches of parts as a function, and the toy shot of the engine's tests."""

import pytest
from click.testing import CliRunner

from hairpipe.graphs.experiments.bench import commands

from ...engine.conftest import shot, trusted  # noqa: F401


@pytest.fixture
def bench():
    """Call a bench with arguments in one text; what is neither an exit nor a result is raised."""

    def call(arguments):
        result = CliRunner().invoke(commands.bench, arguments.split(), prog_name="bench")
        if result.exception is not None and not isinstance(result.exception, SystemExit):
            raise result.exception
        return result

    return call
