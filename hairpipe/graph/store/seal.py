"""Checksums of compiled kernels: numba stores them as pickles and loads them unchecked.

The digest follows the pickle in the same file, which is written atomically, so that any number of processes may write
and be killed; numba alone can read such a file, too. A file with a wrong digest, or without one, is removed, and numba
compiles again.
"""

import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from importlib.abc import MetaPathFinder
from importlib.machinery import ModuleSpec, PathFinder, SourceFileLoader
from importlib.util import spec_from_file_location
from io import BytesIO
from pathlib import Path
from types import ModuleType
from typing import IO, Any

from hairpipe.graph.store.atomic import discard
from hairpipe.graph.store.digest import DIGEST_BYTES, hasher

CACHING = "numba.core.caching"
"""The module of numba that reads and writes kernels."""
MARK = b"\nhairpipe "
LENGTH = len(MARK) + DIGEST_BYTES

_removed: list[Path] = []


def seal(data: bytes) -> bytes:
    """Return the seal that follows the bytes of a kernel."""
    return MARK + hasher("kernel", data).digest()


def is_sealed(path: Path) -> bool:
    """Whether a kernel is as it was written; OSError where it cannot be read."""
    data = path.read_bytes()
    return data[-LENGTH:] == seal(data[:-LENGTH])


def removed() -> list[Path]:
    """Name the damaged kernels that this process has removed since the last call."""
    found = list(_removed)
    _removed.clear()
    return found


def guard_kernels() -> None:
    """Let numba load only sealed kernels in this process, whether it has been imported or not."""
    if CACHING in sys.modules:
        guard(sys.modules[CACHING].IndexDataCacheFile)
    elif not any(isinstance(finder, Finder) for finder in sys.meta_path):
        sys.meta_path.insert(0, Finder())


class Finder(MetaPathFinder):
    """Import hook that guards the module of numba that reads kernels; many workers never import it."""

    def find_spec(self, name: str, path: Sequence[str] | None, target: ModuleType | None = None) -> ModuleSpec | None:
        """Find that module alone."""
        spec = PathFinder.find_spec(name, path) if name == CACHING else None
        return spec and spec_from_file_location(name, spec.origin, loader=GuardingLoader(name, str(spec.origin)))


class GuardingLoader(SourceFileLoader):
    """Imports a module as usual, and guards the class that it defines."""

    def exec_module(self, module: ModuleType) -> None:
        """Import the module."""
        super().exec_module(module)
        guard(module.IndexDataCacheFile)


def guard(cache_file: Any) -> None:
    """Patch numba's cache class to check the kernels it loads, and to seal those it saves; in place."""
    load_index, load_data, open_for_write = cache_file._load_index, cache_file._load_data, cache_file._open_for_write

    def load_sealed_index(self: Any) -> dict[Any, str]:
        return load_index(self) if is_there(Path(self._index_path)) else {}

    def load_sealed_data(self: Any, name: str) -> Any:
        if not is_there(Path(self._data_path(name))):
            raise FileNotFoundError(name)  # for numba, a kernel that has gone
        return load_data(self, name)

    @contextmanager
    def open_to_seal(self: Any, path: str) -> Iterator[IO[bytes]]:
        buffer = BytesIO()
        yield buffer
        data = buffer.getvalue()
        with suppress(OSError):  # of a full disk, say: a kernel that is not kept costs time and nothing else
            Path(path).parent.mkdir(parents=True, exist_ok=True)
            with open_for_write(self, path) as file:
                file.write(data + seal(data))

    if load_index.__name__ != load_sealed_index.__name__:
        cache_file._load_index, cache_file._load_data = load_sealed_index, load_sealed_data
        cache_file._open_for_write = open_to_seal


def is_there(path: Path) -> bool:
    """Whether an intact kernel is there; a damaged one is removed."""
    try:
        if is_sealed(path):
            return True
    except FileNotFoundError:
        return False
    except OSError:
        pass
    with suppress(OSError):
        discard(path)
    _removed.append(path)
    return False
