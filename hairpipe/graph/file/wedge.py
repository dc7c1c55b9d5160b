"""Wedges: `[wedge.NAME]` in a graph file lists varied settings and their values.

    [wedge.grip]
    axes.hair.stiction.force = [1e-6, 2e-6, 4e-6]
    axes.hair.air.drag = { from = 0.5, to = 2.0, count = 3 }
    where = [["force", "<", 4e-6]]
    show = ["picture"]
    measures = ["motion"]
    stop = [["watch.longest stretch [%]", ">", 10.0]]

Every combination of the values is a variant; with `joint = true` the n-th values of all axes are combined.
"""

import math
import operator
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any, NamedTuple

from hairpipe.errors import BadInput
from hairpipe.graph.file.axis import read_axis
from hairpipe.graph.file.overrides import WEDGE, nodes_of
from hairpipe.graph.file.read import GraphText
from hairpipe.graph.file.variant_names import short_names, variant_name
from hairpipe.graph.node.declare import RESERVED
from hairpipe.graph.node.fields import SHORTHAND
from hairpipe.graph.node.messages import brief, nearest

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
        """Node of the compared column."""
        return self.left.partition(".")[0]

    @property
    def column(self) -> str:
        """The compared column."""
        return self.left.partition(".")[2]

    def holds(self, left: Any, right: Any) -> Any:
        """Compare two values, or arrays value by value."""
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
        """Shortest unique names of the varied settings."""
        return short_names(self.axes)


def read_wedges(text: GraphText) -> dict[str, Wedge]:
    """Read the wedges of a graph file; BadInput for errors other than those of the variants."""
    given = text.tables.get(WEDGE, {})
    for name, table in given.items() if isinstance(given, dict) else [("", given)]:
        plain = name.isascii() and name.replace("-", "").replace("_", "").isalnum() and len(name) <= MOST_LETTERS
        if not isinstance(table, dict) or not plain:
            right = "[wedge.NAME], of letters, digits, - and _; no node is called wedge"
            raise BadInput(
                f"wedge.{name} = {brief(table)} is not a wedge", where=text.place(WEDGE, [name]), right=right
            )
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
        """Read the wedge."""
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
        """Return the error with the place of this wedge."""
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
                raise self.fault(
                    f"where: no axis '{comparison.left[:60]}'", ["where"], nearest(comparison.left, [*axes])
                )
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
                raise self.fault(
                    f"stop: '{comparison.left[:60]}' is not the name of a column", ["stop"], '"node.column"'
                )
            if not isinstance(comparison.right, int | float) or isinstance(comparison.right, bool):
                raise self.fault(
                    f"stop: {brief(comparison.right)} is not a number", ["stop"], "a number to compare with"
                )
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
        """Read names of nodes."""
        given = self._table.get(key, [])
        if not isinstance(given, list) or not all(isinstance(name, str) for name in given):
            raise self.fault(f"{key} = {brief(given)}", [key], 'a list of nodes, as ["picture"]')
        for name in given:
            self.check_node(key, name)
        return tuple(given)

    def check_node(self, key: str, name: str) -> None:
        """Refuse a name that is not a node."""
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
    """Whether a setting equals another or is in its group."""
    return f"{target}.".startswith(f"{other}.")
