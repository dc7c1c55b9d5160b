"""Differences between the keys of two evaluations of a node at a frame, part by part."""

import json
from collections.abc import Iterator
from typing import Any, TypeGuard

from hairpipe.graph.store.digest import Parts
from hairpipe.graph.store.store import Store


def differences(old: Parts, new: Parts, modules: dict[str, str], store: Store) -> Iterator[str]:
    """Describe the differences, in the order type, settings, inputs, time, code.

    modules  of the new digest of code; those of the old digest are in the store
    """
    if old["type"] != new["type"]:
        yield f"type {old['type']} -> {new['type']}"
        return
    yield from settings(old["settings"], new["settings"], "setting ")
    yield from inputs(old["inputs"], new["inputs"])
    yield from settings(old["time"] or {}, new["time"] or {}, "")
    if old["code"] != new["code"]:
        yield from code(json.loads(store.recall(old["code"]) or "{}"), modules)


def settings(old: dict[str, Any], new: dict[str, Any], label: str) -> Iterator[str]:
    """Compare settings by name, groups field by field, files by their bytes."""
    for name in sorted(old.keys() | new.keys()):
        before = old.get(name)
        after = new.get(name)
        if json.dumps(before) == json.dumps(after):
            continue
        if is_file(before) and is_file(after):
            yield f"contents of the file of {label}{name}"
        elif is_group(before) and is_group(after):
            yield from settings(before, after, f"{label}{name}.")
        else:
            yield f"{label}{name} {formatted(before)} -> {formatted(after)}"


def inputs(old: dict[str, Any], new: dict[str, Any]) -> Iterator[str]:
    """Compare the inputs of each socket; of several frames, list those that differ."""
    for name in sorted(old.keys() | new.keys()):
        before = old.get(name)
        after = new.get(name)
        if before == after:
            continue
        if before is None or after is None:
            yield f"input {name} {'connected' if before is None else 'disconnected'}"
        elif is_range(before) and is_range(after):
            yield f"input {name} {frames(dict(before), dict(after))}"
        else:
            yield f"input {name}"


def frames(old: dict[int, str], new: dict[int, str]) -> str:
    """Describe the differing frames of a range."""
    if old.keys() != new.keys():
        return f"frames {min(old)}-{max(old)} -> {min(new)}-{max(new)}"
    changed = [frame for frame in new if old[frame] != new[frame]]
    return f"at frame {changed[0]}" + (f" and {len(changed) - 1} more" if len(changed) > 1 else "")


def code(old: dict[str, str], new: dict[str, str]) -> Iterator[str]:
    """List differing modules, versions and class of processor; "code" if the old ones are unknown."""
    if not old:
        yield "code"
        return
    for name in sorted(old.keys() | new.keys()):
        if old.get(name) == new.get(name):
            continue
        what, _, kind = name.removesuffix(")").partition(" (")
        if kind:
            yield f"{kind} of {what} {old.get(name, 'unknown')} -> {new.get(name, 'unknown')}"
        else:
            yield f"code {name}" + (" (new)" if name not in old else " (no longer used)" if name not in new else "")


def is_file(value: Any) -> bool:
    """Whether a keyed setting is a file."""
    return isinstance(value, dict) and value.keys() == {"file", "suffix"}


def is_range(value: Any) -> bool:
    """Whether the input of a socket is a range of frames."""
    return isinstance(value, list) and isinstance(value[0], list)


def is_group(value: Any) -> TypeGuard[dict[str, Any]]:
    """Whether a keyed setting is a group."""
    return isinstance(value, dict) and not is_file(value)


def formatted(value: Any) -> str:
    """Return a setting as in a graph file; a description of an absent value, a group or a file."""
    if value is None:
        return "absent"
    return "a file" if is_file(value) else "a group" if is_group(value) else json.dumps(value)
