"""Wedges: `[wedge.NAME]` in a graph file lists varied settings and their values.

    [wedge.grip]
    axes.hair.stiction.force = [1e-6, 2e-6, 4e-6]
    axes.hair.air.drag = { from = 0.5, to = 2.0, count = 3 }
    where = [["force", "<", 4e-6]]
    show = ["picture"]
    measures = ["motion"]
    stop = [["watch.longest stretch [%]", ">", 10.0]]

Every combination of the values is a variant; with `joint = true` the n-th values of all axes are combined.

Values along an axis of a wedge: a list, an evenly spaced range, or random numbers from a seed.

Names of variants, from the settings that differ: `force=2e-06,drag=0.5`, which can be part of a file name.
"""

import json
import math
import operator
import random
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any, NamedTuple, TypeGuard

from hairpipe.engine.file.overrides import WEDGE, nodes_of
from hairpipe.engine.file.read import GraphText
from hairpipe.engine.node.declare import RESERVED
from hairpipe.engine.node.messages import brief, nearest
from hairpipe.engine.node.settings import SHORTHAND
from hairpipe.engine.store.digest import digest_bytes
from hairpipe.errors import BadInput

MOST_VALUES = 1000
LIST, RANGE = "a list of values", "{ from = 0.1, to = 1.0, count = 4 }, with log = true in equal ratios"
RANDOM = "{ random = { from = 0.1, to = 1.0, count = 4 }, seed = 1 }"
DIGITS, RANDOM_DIGITS = 12, 6
"""Significant digits of the numbers of a range, and of random numbers."""


def read_axis(name: str, given: Any) -> tuple[Any, ...]:
    """Read the values of one setting; BadInput if there are no values, or one occurs twice.

    name  of the setting; it is part of the seed, so axes of the same seed are independent
    """
    values = values_of(name, given)
    if not values:
        raise BadInput("no values", right=LIST)
    twice = next((value for place, value in enumerate(values) if value in values[:place]), None)
    if twice is not None:
        raise BadInput(f"{brief(twice)} occurs twice", right="every value once")
    return values


def values_of(name: str, given: Any) -> tuple[Any, ...]:
    if isinstance(given, list):
        return tuple(given)
    if isinstance(given, dict) and "random" in given:
        seed = given.get("seed")
        span = given["random"]
        if given.keys() != {"random", "seed"} or type(seed) is not int or not isinstance(span, dict):
            raise BadInput(brief(given), right=RANDOM)
        start, end, count, log = read_span(span, RANDOM)
        draw = random.Random(f"{seed} {name}")
        return tuple(rounded(between(start, end, draw.random(), log=log), RANDOM_DIGITS) for _ in range(count))
    if not isinstance(given, dict):
        raise BadInput(f"{brief(given)} is not an axis", right=f"{LIST}, or {RANGE}")
    start, end, count, log = read_span(given, RANGE)
    numbers = [rounded(between(start, end, k / max(1, count - 1), log=log), DIGITS) for k in range(count)]
    whole = isinstance(start, int) and isinstance(end, int) and all(number.is_integer() for number in numbers)
    return tuple(map(int, numbers) if whole else numbers)


def read_span(given: Mapping[str, Any], right: str) -> tuple[float, float, int, bool]:
    """Read the ends of a range, the number of its values, and whether their ratios are equal."""
    start, end, count = (given.get(key) for key in ("from", "to", "count"))
    log = given.get("log", False)
    known = given.keys() <= {"from", "to", "count", "log"} and isinstance(log, bool)
    if not known or not is_number(start) or not is_number(end) or type(count) is not int:
        raise BadInput(brief(given), right=right)
    if not 1 <= count <= MOST_VALUES:
        raise BadInput(f"count = {count}", right=f"1 to {MOST_VALUES}")
    if log and not min(start, end) > 0.0:
        raise BadInput(f"log = true from {start} to {end}", right="numbers above 0")
    return start, end, count, log


def is_number(value: Any) -> TypeGuard[float]:
    return type(value) in (int, float) and abs(value) < 1e300


def between(start: float, end: float, share: float, *, log: bool) -> float:
    return start * (end / start) ** share if log else start + share * (end - start)


def rounded(value: float, digits: int) -> float:
    return float(f"{value:.{digits}g}")


PLAIN = re.compile(r"[^\w.+-]+", re.ASCII)
MARK, LONGEST_NAME = 6, 120


def short_names(targets: Iterable[str]) -> dict[str, str]:
    """Return the shortest unique suffix of every dotted name."""
    paths = [target.split(".") for target in targets]

    def alike(path: list[str], count: int) -> int:
        return sum(other[-count:] == path[-count:] for other in paths)

    counts = [next(n for n in range(1, len(path) + 1) if n == len(path) or alike(path, n) == 1) for path in paths]
    return {".".join(path): ".".join(path[-count:]) for path, count in zip(paths, counts, strict=True)}


def variant_name(names: Mapping[str, str], settings: Mapping[str, Any]) -> str:
    """Return the name of a variant, unique for its settings and independent of other variants.

    names  short names of the settings
    """
    name = ",".join(f"{names[target]}={word(value)}" for target, value in settings.items())
    return name if len(name) <= LONGEST_NAME else f"{name[: LONGEST_NAME - MARK - 1]}-{mark(name)}"


def word(value: Any) -> str:
    """Return a value in characters of any file system; a digest is added if characters were replaced."""
    text = value if isinstance(value, str) else json.dumps(value, default=str)
    if isinstance(value, float):
        exact = [short for digits in range(1, 18) if float(short := f"{value:.{digits}g}") == value]
        text = min(exact, key=len)
    clean = PLAIN.sub("-", text)
    return text if clean == text else f"{clean.strip('-')[:30]}-{mark(text)}"


def mark(text: str) -> str:
    return digest_bytes("variant", text.encode())[:MARK]


KEYS = ("axes", "joint", "where", "show", "measures", "stop")
MOST_VARIANTS = 1000
MOST_LETTERS = 100
RELATIONS = {
    "<": operator.lt,
    "<=": operator.le,
    "==": operator.eq,
    "!=": operator.ne,
    ">=": operator.ge,
    ">": operator.gt,
}
RIGHT = "one of " + " ".join(RELATIONS)


class Comparison(NamedTuple):
    """A comparison: of an axis with a value or another axis, or of a column of a measure with a number."""

    left: str
    relation: str
    right: Any

    @property
    def node(self) -> str:
        return self.left.partition(".")[0]

    @property
    def column(self) -> str:
        return self.left.partition(".")[2]

    def holds(self, left: Any, right: Any) -> Any:
        return RELATIONS[self.relation](left, right)


@dataclass(frozen=True)
class Wedge:
    """Variants of a graph.

    axes      values of every varied setting, by `node.setting` or `node.group.setting`
    joint     whether the settings vary together
    variants  settings of every variant, by its name, in the order of the last axis first
    show      nodes whose pictures are shown
    measures  nodes whose tables are compared
    stop      conditions on `node.column` that end a variant at the first frame at which one holds
    """

    name: str
    axes: dict[str, tuple[Any, ...]]
    joint: bool
    variants: dict[str, dict[str, Any]]
    show: tuple[str, ...]
    measures: tuple[str, ...]
    stop: tuple[Comparison, ...]

    @property
    def short_names(self) -> dict[str, str]:
        return short_names(self.axes)


def read_wedges(text: GraphText) -> dict[str, Wedge]:
    """Read the wedges of a graph file; BadInput for errors other than those of the variants."""
    given = text.tables.get(WEDGE, {})
    for name, table in given.items() if isinstance(given, dict) else [("", given)]:
        plain = name.isascii() and name.replace("-", "").replace("_", "").isalnum() and len(name) <= MOST_LETTERS
        if not isinstance(table, dict) or not plain:
            right = "[wedge.NAME], of letters, digits, - and _; no node is called wedge"
            what = f"wedge.{name} = {brief(table)} is not a wedge"
            raise BadInput(what, where=text.place(WEDGE, [name]), right=right)
    return {name: WedgeReader(text, name, table).read() for name, table in given.items()}


def find_wedge(text: GraphText, name: str) -> Wedge:
    """Find a wedge by its name; BadInput with the nearest name if it is unknown."""
    wedges = read_wedges(text)
    if name not in wedges:
        raise BadInput(f"no wedge '{name}'", where=text.path, right=nearest(name, list(wedges)))
    return wedges[name]


class WedgeReader:
    """Reads one table."""

    def __init__(self, text: GraphText, name: str, table: Mapping[str, Any]) -> None:
        self._text, self._name, self._table = text, name, table
        self._nodes = nodes_of(text.tables)

    def read(self) -> Wedge:
        for key in self._table.keys() - set(KEYS):
            raise self.fault(f"unknown key '{key}'", [key], nearest(key, KEYS))
        axes = self.axes()
        joint = self._table.get("joint", False)
        if not isinstance(joint, bool):
            raise self.fault(f"joint = {brief(joint)}", ["joint"], "true or false")
        show, measures = self.names("show"), self.names("measures")
        settings = self.kept(axes, self.combined(axes, joint))
        variants = {variant_name(short_names(axes), chosen): chosen for chosen in settings}
        return Wedge(self._name, axes, joint, variants, show, measures, self.stop())

    def fault(self, what: str, names: Sequence[str], right: str) -> BadInput:
        return BadInput(what, where=self._text.place(f"{WEDGE}.{self._name}", names), right=right)

    def axes(self) -> dict[str, tuple[Any, ...]]:
        """Read the axes, one for each setting: `node.length.value` is `node.length`."""
        given = self._table.get("axes")
        if not isinstance(given, dict) or not given:
            what = "no axes" if given is None else f"axes = {brief(given)} is not a table of axes"
            raise self.fault(what, ["axes"], "axes.NODE.SETTING = [0.1, 0.2]")
        axes: dict[str, tuple[Any, ...]] = {}
        for given_target, value in flat(given):
            target = given_target.removesuffix(f".{SHORTHAND}") if given_target.count(".") > 1 else given_target
            node, _, setting = target.partition(".")
            if node not in self._nodes or not setting or setting.split(".")[0] in RESERVED:
                right = nearest(node, list(self._nodes)) if node not in self._nodes else "axes.NODE.SETTING"
                raise self.fault(f"axes: cannot set '{target[:60]}'", [node], right)
            other = next((known for known in axes if within(known, target) or within(target, known)), None)
            if other is not None:
                raise self.fault(f"axes: two of '{min(other, target, key=len)}'", [target.split(".")[-1]], "one axis")
            try:
                axes[target] = read_axis(target, value)
            except BadInput as fault:
                raise self.fault(f"axes: {target}: {fault.what}", target.split("."), fault.right or "") from None
        return axes

    def combined(self, axes: Mapping[str, tuple[Any, ...]], joint: bool) -> list[dict[str, Any]]:
        """Combine the values of the axes."""
        counts = {target: len(values) for target, values in axes.items()}
        if joint and len(set(counts.values())) > 1:
            lengths = ", ".join(f"{target}: {count}" for target, count in counts.items())
            raise self.fault(f"joint axes of different lengths ({lengths})", ["joint"], "as many values of each")
        count = max(counts.values()) if joint else math.prod(counts.values())
        if count > MOST_VARIANTS:
            raise self.fault(f"{count:,} variants are too many", ["axes"], f"at most {MOST_VARIANTS:,}")
        rows = zip(*axes.values(), strict=True) if joint else product(*axes.values())
        return [dict(zip(axes, row, strict=True)) for row in rows]

    def kept(self, axes: Mapping[str, Any], settings: list[dict[str, Any]]) -> list[dict[str, Any]]:
        """Return the variants for which every comparison of `where` holds."""
        known = {f"{target}.{SHORTHAND}": target for target in axes}
        known |= {alias: target for target, name in short_names(axes).items() for alias in (target, name)}
        for comparison in self.comparisons("where", '[["hair.air.drag", "<", 2.0]]'):
            if comparison.left not in known:
                what = f"where: no axis '{comparison.left[:60]}'"
                raise self.fault(what, ["where"], nearest(comparison.left, [*axes]))
            left = known[comparison.left]
            right = known.get(comparison.right) if isinstance(comparison.right, str) else None
            try:
                settings = [s for s in settings if comparison.holds(s[left], s[right] if right else comparison.right)]
            except TypeError:
                what = f"where: {left} cannot be compared with {brief(comparison.right)}"
                raise self.fault(what, ["where"], "values of one kind") from None
        if not settings:
            raise self.fault("no variant is left", ["where"], "a condition that some values meet")
        return settings

    def stop(self) -> tuple[Comparison, ...]:
        """Read the conditions that end a variant."""
        found = self.comparisons("stop", '[["watch.longest stretch [%]", ">", 10.0]]')
        for comparison in found:
            self.check_node("stop", comparison.node)
            if not comparison.column:
                what = f"stop: '{comparison.left[:60]}' is not the name of a column"
                raise self.fault(what, ["stop"], '"node.column"')
            if not isinstance(comparison.right, int | float) or isinstance(comparison.right, bool):
                what = f"stop: {brief(comparison.right)} is not a number"
                raise self.fault(what, ["stop"], "a number to compare with")
        return tuple(found)

    def comparisons(self, key: str, right: str) -> list[Comparison]:
        """Read a list of comparisons, each [left, relation, right]."""
        given = self._table.get(key, [])
        if not isinstance(given, list):
            raise self.fault(f"{key} = {brief(given)}", [key], right)
        for row in given:
            if not isinstance(row, list) or len(row) != 3 or not all(isinstance(word, str) for word in row[:2]):
                raise self.fault(f"{key}: {brief(row)} is not a comparison", [key], right)
            if row[1] not in RELATIONS:
                raise self.fault(f"{key}: '{row[1][:60]}' is not a relation", [key], RIGHT)
        return [Comparison(*row) for row in given]

    def names(self, key: str) -> tuple[str, ...]:
        given = self._table.get(key, [])
        if not isinstance(given, list) or not all(isinstance(name, str) for name in given):
            raise self.fault(f"{key} = {brief(given)}", [key], 'a list of nodes, as ["picture"]')
        for name in given:
            self.check_node(key, name)
        return tuple(given)

    def check_node(self, key: str, name: str) -> None:
        if name not in self._nodes:
            raise self.fault(f"{key}: no node '{name[:60]}'", [key], nearest(name, list(self._nodes)))


def flat(tables: Mapping[str, Any], prefix: str = "") -> list[tuple[str, Any]]:
    """List the values in nested tables by dotted name; a range is a value."""
    found = []
    for name, value in tables.items():
        is_end = not isinstance(value, dict) or not value or {"from", "random"} & value.keys()
        found += [(prefix + name, value)] if is_end else flat(value, f"{prefix}{name}.")
    return found


def within(target: str, other: str) -> bool:
    return f"{target}.".startswith(f"{other}.")
