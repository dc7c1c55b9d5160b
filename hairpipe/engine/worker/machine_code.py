"""Machine code of kernels: when numba generates it, and where it is kept.

Numba detects edits of the file that defines a kernel, not of those that it calls. A process is told in its environment
of a table with the digest of every module and of all its imports, which was made before it started: it is part of the
name of the folder of the module's kernels. So an edit leaves all kernels current that cannot contain it, and checkouts
with the same code share theirs. Code enters a kernel also by the types of its arguments (fields of a record, the
kernels of a strand model, operators on lanes), so a kernel is looked up by the digests of their modules too. A module
without an entry in the table has its kernels compiled by each process.

A kernel is one file, which holds what numba looks it up by: there is no index that processes overwrite each other, or
that names types which another process cannot import. The seal that follows the pickle is checked before numba reads it.
Numba's locators alone choose folders; they check no file that is loaded, and see no types.

One process compiles a kernel, while others that need it wait for its file.

The folders lie where only this user can write, never in a store: a store may come from anywhere, and kernels are code.

Numba optimises every function by itself, generates its machine code, and does both again in each function that
contains it. Nobody calls the first code of a function that is only inlined, nor that of the body of a parallel loop,
which is compiled by itself, in the loop over a thread's share, and in the function. Here such a function stays
intermediate code, in memory and in the folder of kernels, and the function that contains it is optimised as a whole.
"""

import errno
import fcntl
import json
import os
import shutil
import sys
import time
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from functools import cache
from importlib.abc import MetaPathFinder
from importlib.machinery import ModuleSpec, PathFinder, SourceFileLoader
from importlib.util import spec_from_file_location
from io import BytesIO
from pathlib import Path
from types import FunctionType, ModuleType
from typing import IO, Any, NamedTuple, Self

import hairpipe
from hairpipe.engine.code import INSTALLED, CodeReader
from hairpipe.engine.store.atomic import replacing
from hairpipe.engine.store.digest import digest, digest_bytes
from hairpipe.engine.store.fingerprint import is_there, seal
from hairpipe.engine.store.ownership import fault_of, make_own, own_folder
from hairpipe.engine.store.store import Store
from hairpipe.engine.worker.threading_layer import choose_layer
from hairpipe.errors import BadInput
from hairpipe.plain_file import Stamp, stamp_of

KNOWN = (0, 68)
"""Version of numba whose internal classes are patched here; another one compiles as it does by itself.

`hairpipe bench first-use graphs/demo.toml` shows what the patch saves: with another version here, nothing is patched.
A similar change of numba was closed without a merge: https://github.com/numba/numba/pull/9566
"""


def defer_code() -> None:
    """Patch numba's modules of compilation, in place: libraries of functions generate their code when it is needed."""
    import numba
    from numba.core import codegen, compiler

    if numba.version_info[:2] != KNOWN:
        return
    from numba.core.environment import lookup_environment

    class DeferredLibrary(codegen.JITCodeLibrary):
        """A library of functions, which are linked into others as they were written until one of them is called."""

        _pending, _compiled_object = False, None

        def _optimize_final_module(self) -> None:
            """Leave it to `_generate`."""

        def _finalize_final_module(self) -> None:
            """Make code that was read from a file ready; other code is generated now only if it calls itself."""
            if self._compiled_object is not None:
                super()._finalize_final_module()
                return
            self._finalize_dynamic_globals()
            self._verify_declare_only_symbols()
            self._finalized = self._pending = True
            if any(name.startswith(codegen.RuntimeLinker.PREFIX) for name in self._globals()):
                self._generate()

        def _generate(self) -> None:
            """Optimise the module and generate its code, with the environments of all functions in it."""
            self._pending = False
            super()._optimize_final_module()
            self._final_module.verify()
            super()._finalize_final_module()
            for name in self._globals():
                environment = lookup_environment(name)
                if environment is not None:
                    self._codegen.set_env(name, environment)  # pyright: ignore[reportAttributeAccessIssue]

        def _globals(self) -> list[str]:
            return [variable.name for variable in self._final_module.global_variables]

        def _defines(self, name: str) -> bool:
            try:
                return not self._final_module.get_function(name).is_declaration
            except NameError:
                return False

        def get_pointer_to_function(self, name: str) -> int:
            """Return the address of a function, 0 where there is none of that name."""
            self._ensure_finalized()
            if self._pending and self._defines(name):
                self._generate()
            return super().get_pointer_to_function(name)

        def serialize_using_object_code(self) -> Any:
            """Give what is kept of the library in a file."""
            return self.serialize_using_bitcode() if self._pending else super().serialize_using_object_code()

    set_env = codegen.JITCPUCodegen.set_env
    define_pipeline = compiler.DefaultPassBuilder.define_parfor_gufunc_pipeline

    def set_env_of_generated(self: Any, name: str, environment: Any) -> None:
        if self._engine.is_symbol_defined(name):
            set_env(self, name, environment)

    def define_without_entries(state: Any) -> Any:
        """Leave out the entries for Python and for C of the body of a parallel loop, which nobody calls."""
        state.flags.no_cpython_wrapper = state.flags.no_cfunc_wrapper = True
        return define_pipeline(state)

    codegen.JITCPUCodegen._library_class = DeferredLibrary
    codegen.JITCPUCodegen.set_env = set_env_of_generated  # pyright: ignore[reportAttributeAccessIssue]
    builder: Any = compiler.DefaultPassBuilder
    builder.define_parfor_gufunc_pipeline = staticmethod(define_without_entries)


def shorten_compilation() -> None:
    """Patch what numba repeats for each call of LLVM and each comparison of options, in place; code stays the same.

    Numba adds up the duration of each call of LLVM, in every function that is being compiled. It compares options as
    new dictionaries with all of them. It also generates an entry for C in each function, which nobody calls.
    """
    import numba
    from llvmlite.binding import ffi
    from numba.core import compiler, targetconfig

    if numba.version_info[:2] != KNOWN:
        return
    config: Any = targetconfig.TargetConfig

    def equals(self: Any, other: Any) -> bool:
        if not isinstance(other, config):
            return NotImplemented
        return self._values == other._values or self.values() == other.values()

    config.__eq__, config.__hash__ = equals, lambda self: hash(type(self))
    compiler.Flags.options["no_cfunc_wrapper"]._default = True
    ffi.lib._lock._cblist.clear()


TABLE = "HAIRPIPE_KERNELS"
"""Variable that names the table of digests, a JSON object of the fields of `Entry` by file; kernels lie next to it."""
CACHING = "numba.core.caching"
"""The module of numba that reads and writes kernels."""
FOLDER_DIGITS = 24
"""Length of the digest at the end of the name of each folder of kernels, and of each table."""
VERSIONED = {"builtins", "llvmlite", "numba", "numpy", *sys.stdlib_module_names}
"""Distributions whose types need no digest: numba's version and Python's are part of every look-up."""


class Entry(NamedTuple):
    """Entry of a module in the table."""

    module: str
    code: str  # digest of the module and of all its imports
    key: str  # digest of the code and the compiler options of its kernels

    @property
    def folder(self) -> str:
        return f"{self.module}-{self.key[:FOLDER_DIGITS]}"


def write_table(folder: Path, entries: Mapping[str, Entry]) -> Path:
    """Write the table of digests, see `TABLE`, into the folder of kernels, and return its path."""
    text = json.dumps(entries)
    path = folder / f"table-{digest_bytes('kernels', text.encode())[:FOLDER_DIGITS]}"
    try:
        os.utime(path)
    except OSError:
        with replacing(path, lasting=False) as file:
            file.write_text(text, encoding="utf-8")
    return path


@cache
def table() -> dict[str, Entry]:
    """Read the table of digests that this process was told of; empty where there is none."""
    path = os.environ.get(TABLE)
    return {file: Entry(*fields) for file, fields in json.loads(Path(path).read_bytes()).items()} if path else {}


def guard_kernels() -> None:
    """Let numba load only sealed kernels of current code in this process, whether it has been imported or not.

    It generates machine code only where it is needed, and its seconds of compilation are counted.
    """
    table()
    if CACHING in sys.modules:
        guard(sys.modules[CACHING])
    elif not any(isinstance(finder, Finder) for finder in sys.meta_path):
        sys.meta_path.insert(0, Finder())


class Finder(MetaPathFinder):
    """Import hook that guards the module of numba that reads kernels; many workers never import it."""

    def find_spec(self, name: str, path: Sequence[str] | None, target: ModuleType | None = None) -> ModuleSpec | None:
        spec = PathFinder.find_spec(name, path) if name == CACHING else None
        return spec and spec_from_file_location(name, spec.origin, loader=GuardingLoader(name, str(spec.origin)))


class GuardingLoader(SourceFileLoader):
    """Imports a module as usual, and guards the classes that it defines."""

    def exec_module(self, module: ModuleType) -> None:
        super().exec_module(module)
        guard(module)


class KernelLocator:
    """Tells numba where the kernels of a function lie, as its own locators do; an empty path: they are not kept."""

    def __init__(self, function: FunctionType, file: str) -> None:
        self._line = function.__code__.co_firstlineno
        self._py_file = file
        entry = table().get(file)
        self._path = str(Path(os.environ[TABLE]).parent / entry.folder) if entry else ""

    @classmethod
    def from_function(cls, function: FunctionType, file: str) -> Self | None:
        """Locate a function of this file; None for numba's own place, where we were told of none or it is installed."""
        installed = any(folder in Path(file).parts for folder in INSTALLED) and file not in table()
        return None if TABLE not in os.environ or installed else cls(function, file)

    def ensure_cache_path(self) -> None:
        """Leave the folder to whoever writes to it."""

    def get_cache_path(self) -> str:
        return self._path

    def get_source_stamp(self) -> str:
        """Digest the bytes of the file: functions of one name are distinguished by their lines."""
        return digest_of_file(self._py_file, Path(self._py_file).stat().st_mtime_ns) if self._path else ""

    def get_disambiguator(self) -> str:
        """Number the first line of the function."""
        return str(self._line)


@cache
def digest_of_file(file: str, modified: int) -> str:
    """Digest the bytes of a file, once a process while it is not modified."""
    return digest_bytes("kernels", Path(file).read_bytes())


def guard(caching: Any) -> None:
    """Patch numba's module of caches: where kernels lie, how they are looked up, checked and sealed; in place."""
    locators = caching.CacheImpl._locator_classes
    cache_file = caching.IndexDataCacheFile
    if KernelLocator in locators:
        return
    locators.insert(0, KernelLocator)
    load_data, save_data, open_for_write = cache_file._load_data, cache_file._save_data, cache_file._open_for_write
    save_overload = caching.Cache.save_overload

    def load(self: Any, key: Any) -> Any:
        name = name_of(self, key)
        if name is None:
            return None
        data = read(self, name, key)
        if data is None and claim(self, Path(self._data_path(name))):
            data = read(self, name, key)
        if data is not None:
            release(self)
        return data

    def read(self: Any, name: str, key: Any) -> Any:
        if is_there(Path(self._data_path(name))):
            with suppress(OSError):  # of one that has gone since
                known, data = load_data(self, name)
                with suppress(OSError):
                    os.utime(self._cache_path)
                return data if known == key else None
        return None

    def save(self: Any, key: Any, data: Any) -> None:
        name = name_of(self, key)
        if name and is_current(self._cache_path):
            save_data(self, name, (key, data))

    def save_and_release(self: Any, signature: Any, result: Any) -> None:
        try:
            save_overload(self, signature, result)
        finally:
            release(self._cache_file)

    @contextmanager
    def open_to_seal(self: Any, path: str) -> Iterator[IO[bytes]]:
        buffer = BytesIO()
        yield buffer
        data = buffer.getvalue()
        with suppress(OSError):  # of a full disk, say: a kernel that is not kept costs time and nothing else
            Path(path).parent.mkdir(parents=True, exist_ok=True)
            with open_for_write(self, path) as file:
                file.write(data + seal(Path(path), data))

    cache_file.load, cache_file.save, cache_file._open_for_write = load, save, open_to_seal
    caching.Cache.save_overload = save_and_release
    defer_code()
    shorten_compilation()
    from numba.core.event import TimingListener, register

    class Compilation(TimingListener):
        """Adds up the duration of compilation, and releases kernels that do not compile."""

        def on_end(self, event: Any) -> None:
            super().on_end(event)
            if event._exc_details is not None:
                release(getattr(event.data["dispatcher"]._cache, "_cache_file", None))

    _timing.append(Compilation())
    register("numba:compile", _timing[0])


_timing: list[Any] = []
_claims: dict[Path, tuple[Any, IO[bytes]]] = {}
"""Files of numba's cache, and locked files, by the kernels that this process compiles."""
POLL = 0.02
"""Interval at which a process tries to lock a kernel again [s]."""
LONGEST_WAIT = 60.0
"""Time for which a process waits for a kernel that another one compiles [s]."""


def claim(cache_file: Any, kernel: Path) -> bool:
    """Lock a kernel that is missing, so that one process compiles it; return whether another one has held it before.

    Functions call no function that calls them: two processes do not wait for each other.
    """
    waited = False
    if kernel in _claims:
        return waited
    with suppress(OSError):
        kernel.parent.mkdir(parents=True, exist_ok=True)
        file = kernel.with_suffix(".claim").open("wb")
        _claims[kernel] = cache_file, file
        end = time.monotonic() + LONGEST_WAIT
        while time.monotonic() < end:
            try:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
                return waited
            except BlockingIOError:
                waited = True
                time.sleep(POLL)
    return waited


def release(cache_file: Any) -> None:
    """Unlock the kernels that this process has compiled, or cannot compile."""
    for kernel in [kernel for kernel, (of, _) in _claims.items() if of is cache_file]:
        file = _claims.pop(kernel)[1]
        with suppress(OSError):
            Path(file.name).unlink()
        file.close()


def seconds_compiled() -> float:
    """Return the seconds in which numba has compiled in this process, without kernels that are read from a file."""
    return sum(each.duration for each in _timing if each.done)


def name_of(cache_file: Any, key: tuple[Any, ...]) -> str | None:
    """Name the file of a kernel by all that numba looks it up by; None where it cannot be kept."""
    code = codes_behind(key[0]) if cache_file._cache_path else None
    if code is None:
        return None
    parts = [repr(key), code, repr(cache_file._source_stamp), cache_file._version]  # numba's own stamps are bytes
    return f"{cache_file._index_name.removesuffix('.nbi')}.{digest('kernels', parts)[:FOLDER_DIGITS]}.nbc"


def codes_behind(signature: Any) -> list[str] | None:
    """List the digests of the modules behind the types of a signature; None where one of them is not known.

    A function that is an argument cannot be told from another one in another process.
    """
    from numba.core.types import Callable, Type

    modules = set[str]()
    seen = set[int]()
    queue = [signature]
    while queue:
        thing = queue.pop()
        if id(thing) in seen:
            continue
        seen.add(id(thing))
        if isinstance(thing, Callable):
            return None
        if isinstance(thing, Type):
            modules.add(type(thing).__module__)
            queue.extend(vars(thing).values())
        elif isinstance(thing, type):
            modules.add(thing.__module__)
        elif isinstance(thing, tuple | list):
            queue.extend(thing)
        elif isinstance(thing, dict):
            queue.extend(thing.values())
    files = [file_of(name) for name in sorted(modules) if name.partition(".")[0] not in VERSIONED]
    return [table()[file].key for file in files] if table().keys() >= set(files) else None


def file_of(module: str) -> str:
    """Path of the file of an imported module, read from its dictionary: attributes may import more; empty for none."""
    found = sys.modules.get(module)
    return (isinstance(found, ModuleType) and vars(found).get("__file__")) or ""


def is_current(folder: str) -> bool:
    """Whether nothing has been edited since the table was made that kernels of a folder are compiled of."""
    stamps = _current.get(folder)
    if stamps is not None and all(stamp_of(path) == stamp for path, stamp in stamps.items()):
        return True
    reader = CodeReader(lambda name, make: make())
    alike = [entry for entry in table().values() if entry.key.startswith(folder[-FOLDER_DIGITS:])]
    found = all(reader.code_of(entry.module).digest == entry.code for entry in alike)
    if found:
        _current[folder] = reader.stamps
    return found


_current: dict[str, dict[str, Stamp]] = {}
"""Stamps of the sources behind folders of kernels that were found current."""


WITHOUT_KERNELS = ("app", "engine")
"""Rooms without kernels, and without types that kernels take."""
PRIVATE = "a folder of your own that you alone can write to (chmod go-w)"
SETTINGS = (
    "NUMBA_BOUNDSCHECK",
    "NUMBA_DEBUGINFO",
    "NUMBA_DISABLE_INTEL_SVML",
    "NUMBA_LOOP_VECTORIZE",
    "NUMBA_OPT",
    "NUMBA_SLP_VECTORIZE",
)
"""Of the environment, by which numba compiles otherwise, though it looks a kernel up by none of them."""
KEPT = 16
"""Number of states of a module whose kernels are kept: several checkouts and versions are in use in turn."""
NOTES = "notes"
"""Folder of analyses of modules, next to those of kernels: it is used by all of them, and is not removed."""
UNUSED = 30 * 24 * 3600.0
"""Age since the last use at which kernels are removed [s]."""

_digests: dict[tuple[tuple[str, str], ...], dict[str, str]] = {}
"""Digests of the code behind our modules, by the digests of these alone."""


def kernels_parent() -> Path:
    """Name the folder of all kernels: where numba was told to keep its own, else in the user's cache.

    OSError where he has no home.
    """
    given = os.environ.get("NUMBA_CACHE_DIR")
    return Path(given, "hairpipe").absolute() if given else own_folder("cache") / "kernels"


def claim_kernels(folder: Path) -> Path:
    """Make a folder for kernels that only this user can write to, or check an existing one; returns it.

    Raises BadInput if it belongs to somebody else or others may write to it, OSError if it cannot be made.
    """
    make_own(folder)
    fault = fault_of(folder)
    if fault:
        raise BadInput(f"compiled kernels are code, and the folder for them {fault}", where=folder, right=PRIVATE)
    if not os.access(folder, os.W_OK | os.X_OK):
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), str(folder))
    return folder


def kernels_environment(folder: Path, reader: CodeReader, nodes: Iterable[str] = ()) -> dict[str, str]:
    """Environment of a process that keeps kernels in a claimed folder, for the sources as they are now.

    Writes the table of digests there, with analyses of modules, of which a new store would have none, and removes
    kernels that were not used for long.

    nodes  modules of the node types that are used: they, or what they import, may have kernels that are not ours
    """
    notes = Store(folder / NOTES)
    table = write_table(folder, kernel_digests(reader.with_notes(notes.remember), nodes))
    remove_unused(folder)
    return {TABLE: str(table)}


def share_kernels() -> None:
    """Prepare this process for computation, before it imports kernels: it shares the kernels of runs.

    The threading layer is also that of runs. Raises BadInput if others may write to the folder, or it is read-only.
    """
    try:
        folder = claim_kernels(kernels_parent())
    except OSError as error:
        raise BadInput(f"no folder for kernels: {error}", right="NUMBA_CACHE_DIR=FOLDER") from None
    reader = CodeReader(lambda name, make: make())
    os.environ |= kernels_environment(folder, reader) | choose_layer().settings
    guard_kernels()


def kernel_digests(reader: CodeReader, nodes: Iterable[str]) -> dict[str, Entry]:
    """Digest the code behind every module that may hold kernels, or types that kernels take, by its file.

    A module of ours counts with all that it imports. Those of the user count all together: what one registers with
    numba, an overload or a model of a strand, another may call without importing it. Nodes as above.
    """
    settings = {name: os.environ[name] for name in SETTINGS if name in os.environ}
    ours = our_digests(reader)
    theirs = {name: reader.code_of(name).digest for node in nodes for name in reader.modules_with_kernels(node)}
    digests = ours | dict.fromkeys(theirs, digest("kernels", theirs))
    entries = [
        Entry(name, code, digest("kernels", [digests[name], settings])) for name, code in (ours | theirs).items()
    ]
    return {reader.file_of(entry.module): entry for entry in entries}


def our_digests(reader: CodeReader) -> dict[str, str]:
    """Digest the code behind each module of this package that may hold kernels, once a process while none changes."""
    state = tuple((module, reader.own_digest(module)) for module in kernel_modules())
    if state not in _digests:
        _digests.clear()
        _digests[state] = {module: reader.code_of(module).digest for module, _ in state}
    return _digests[state]


def remove_unused(folder: Path) -> None:
    """Remove the kernels of a module whose states were used before those of `KEPT` others, or not for a month."""
    states = defaultdict[str, list[tuple[float, Path]]](list)
    with suppress(OSError):
        for entry in os.scandir(folder):
            if entry.name != NOTES:
                states[entry.name[:-FOLDER_DIGITS]].append((entry.stat().st_mtime, Path(entry.path)))
    oldest = time.time() - UNUSED
    for found in states.values():
        found.sort(reverse=True)
        for place, (used, path) in enumerate(found):
            if place >= KEPT or used < oldest:
                with suppress(OSError):
                    path.unlink() if path.is_file() else shutil.rmtree(path, ignore_errors=True)


def kernel_modules() -> Iterator[str]:
    """Name the modules of this package that hold kernels, may be called by one, or say where a name is from."""
    root = Path(hairpipe.__file__).parent
    for path in sorted(root.rglob("*.py")):
        parts = path.relative_to(root.parent).with_suffix("").parts
        if parts[1] not in WITHOUT_KERNELS:
            yield ".".join(parts[:-1] if parts[-1] == "__init__" else parts)
