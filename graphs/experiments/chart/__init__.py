"""Charts as PNG, by matplotlib: the same picture gives the same bytes."""

from importlib.util import find_spec

from hairpipe.errors import BadInput

if find_spec("matplotlib") is None:
    raise BadInput("matplotlib is not installed", where="charts", right="pip install 'hairpipe[experiments]'")
