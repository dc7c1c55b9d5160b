"""A worker process: evaluates one action at a time, reads and writes the store, and exchanges JSON over a pipe.

A job names a node type, settings, the objects of its inputs and the time; the reply is the record that was added to the
store, the object that was lost, or the failure. A worker ends with its coordinator.
"""

import ctypes
import gc
import inspect
import json
import os
import sys
import time
import traceback
from collections.abc import Callable
from contextlib import nullcontext, suppress
from dataclasses import asdict
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

from hairpipe.child import die_with_parent, processor_time
from hairpipe.engine.file.registry import Registry
from hairpipe.engine.file.trust import grant
from hairpipe.engine.node.declare import Cuts, First, NodeType, Origin, Time, Workspace
from hairpipe.engine.node.messages import recorded_warnings
from hairpipe.engine.plan.arguments import Preparations, build_arguments
from hairpipe.engine.store.atomic import workspace
from hairpipe.engine.store.fingerprint import removed
from hairpipe.engine.store.store import Output, Record, Store
from hairpipe.engine.store.values import Values, is_full
from hairpipe.engine.worker.machine_code import file_of, guard_kernels, seconds_compiled
from hairpipe.engine.worker.threading_layer import layer_in_use
from hairpipe.errors import BadInput
from hairpipe.plain_file import stamp_of
from hairpipe.processor import processor_class

_M_TRIM_THRESHOLD, _M_MMAP_MAX = -1, -4
"""Parameters of mallopt(3)."""

SAVED_AFTER = 30.0
"""Time of evaluations after which the states that are only in memory are written: a kill loses no more [s]."""
IDLE = 5.0
"""Time without a job after which they are written [s]."""
COLLECTION = 100_000, 20, 100
"""Thresholds of Python's garbage collector, which searches the many small objects that a compiler keeps."""

Job = dict[str, Any]
Reply = dict[str, Any]


class Worker:
    """Evaluates jobs with the node types and the store of one run."""

    def __init__(self, hello: Job, is_orphan: Callable[[], bool]) -> None:
        if hello["trusted"] is not None:
            grant(hello["trusted"])
        self.registry = Registry(Path(hello["folder"]))
        self.store = Store(Path(hello["store"]))
        self.values = Values(self.store, hello["memory"])
        self.preparations = Preparations()
        self.is_orphan = is_orphan
        self.processor_class = hello["processor_class"]
        self.unsaved = 0.0
        self._unchecked = {path: tuple(stamp) for path, stamp in hello["sources"].items()}
        self._checked: set[str] = set()

    def reply(self, job: Job) -> Reply:
        """Evaluate a job; a failure is part of the reply."""
        self.values.lost()
        try:
            reply: Reply = {"record": asdict(self.evaluate(job))}
        except Exception as error:  # a node may raise anything; the run goes on and says which node it was
            lost = self.values.lost()
            reply = failure(error) if lost is None else {"lost": lost}
        return reply | {"healed": len(removed())} | self.held()

    def save(self) -> Reply:
        """Write the states that are only in memory, as far as the disk has room."""
        with suppress(OSError):
            self.values.write_out()
        return self.held()

    def held(self) -> Reply:
        """Name the states that are only in memory."""
        return {"held": list(self.values.unwritten)}

    def evaluate(self, job: Job) -> Record:
        """Evaluate a job and add its record to the store; BadInput where the processor is of another class."""
        if (own := processor_class()) != self.processor_class:
            raise BadInput(f"the processor of the worker is of class {own}", right=self.processor_class)
        node_type = self.registry.find(job["type"])
        with workspace(self.store.temporary) if node_type.asks(Workspace) else nullcontext() as folder:
            inputs = job["parts"]["inputs"]
            given = job["time"]
            special = {Time: Time(given["frame"], given["fps"]), Cuts: tuple(given["cuts"]), First: given["first"]}
            special |= {Origin: Origin(**(given["origin"] or {})), Workspace: folder}
            arguments = build_arguments(node_type, inputs, job["settings"], special, self.values.get)
            begun = time.perf_counter()
            worked = processor_time()
            compiled = seconds_compiled()
            with recorded_warnings() as warnings:
                try:
                    prepared = self.preparations.prepare(node_type, inputs, job["settings"], self.values.get)
                    result = node_type.function(**arguments, **prepared.arguments)
                finally:
                    self._check_code(node_type)
            self.values.check()
            seconds = time.perf_counter() - begun
            processor = processor_time() - worked
            compiled = seconds_compiled() - compiled
            del arguments
            for path, stamp in job["files"].items():
                if stamp_of(path) != tuple(stamp):  # its key would be wrong
                    raise BadInput("changed while it was read", where=path, right="run again when it is complete")
            outputs = self._put(node_type, result, folder, job["fleeting"])
        record = Record(
            key=job["key"],
            node=job["node"],
            frame=job["frame"],
            parts=job["parts"],
            outputs=outputs,
            state=node_type.state,
            seconds=seconds,
            warnings=tuple(warnings),
            prepare_warnings=prepared.warnings,
            created=time.time(),
            processor=processor,
            processor_class=self.processor_class,
            threading_layer=layer_in_use(),
            compiled=compiled,
        )
        if self.is_orphan():
            raise SystemExit(1)
        self.store.add(record)
        self._pass_on(inputs.get("previous"), record)
        return record

    def _pass_on(self, previous: str | None, record: Record) -> None:
        """Forget the state before a result, and write those that are only in memory where too much depends on them."""
        if previous is not None:
            self.values.forget(previous)
        self.unsaved = self.unsaved + record.seconds if self.values.unwritten else 0.0
        if self.unsaved > SAVED_AFTER:
            self.values.write_out()
            self.unsaved = 0.0

    def _check_code(self, node_type: NodeType) -> None:
        """Refuse the result where a module was edited before it was imported here: the key is of the code before.

        Nodes import within their functions, so this is checked after each call, once for each module.
        """
        new = sys.modules.keys() - self._checked
        paths = {inspect.unwrap(node_type.function).__code__.co_filename, *map(file_of, new)}
        for path in paths & self._unchecked.keys():
            if stamp_of(path) != self._unchecked[path]:
                raise BadInput("changed during the run", where=path, right="run again")
            del self._unchecked[path]
        self._checked |= new

    def _put(self, node_type: NodeType, result: Any, folder: Path | None, fleeting: str | None) -> dict[str, Output]:
        results = node_type.by_output(result)
        return {
            name: self.values.put(results[name], kind, folder, lasting=name != fleeting)
            for name, kind in node_type.outputs.items()
        }


def failure(error: Exception) -> Reply:
    """Describe the exception that is being handled."""
    kind = "input"
    message = str(error)
    parts = {}
    if isinstance(error, BadInput):
        parts = {"what": error.what, "where": error.where and str(error.where), "right": error.right}
    else:
        full = isinstance(error, OSError) and is_full(error)
        kind = "disk" if full else "diverged" if type(error) is ArithmeticError else "node"
        message = f"{type(error).__name__}: {error}"
    return {"failure": {"kind": kind, "message": message, "traceback": traceback.format_exc(), "parts": parts}}


def is_closed(connection: Connection) -> bool:
    """Whether the other end is closed: it never sends anything while a job is being evaluated."""
    try:
        return connection.poll(0)
    except OSError:
        return True


def keep_freed() -> None:
    """Keep freed memory in this process for the next allocation, where its C library is glibc.

    A step of a large groom allocates and frees hundreds of arrays. The kernel would provide new large ones each time,
    and zero them first.
    """
    mallopt = getattr(ctypes.CDLL(None), "mallopt", None)
    if mallopt is not None:
        mallopt(_M_MMAP_MAX, 0)
        mallopt(_M_TRIM_THRESHOLD, -1)


def main(descriptor: int) -> None:
    """Serve a coordinator until it closes the connection."""
    keep_freed()
    gc.set_threshold(*COLLECTION)
    guard_kernels()
    connection = Connection(descriptor)
    try:
        hello = json.loads(connection.recv_bytes())
        die_with_parent()
        worker = Worker(hello, lambda: is_closed(connection))
        while True:
            if not connection.poll(IDLE if worker.values.unwritten else None):
                worker.save()
                continue
            job = json.loads(connection.recv_bytes())
            connection.send_bytes(json.dumps(worker.reply(job) if job else worker.save()).encode())
    except (EOFError, OSError):
        os._exit(0)
