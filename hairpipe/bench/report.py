"""The report of a bench: the machine, and tables of cases; the same for all benches."""

from collections.abc import Callable
from typing import NamedTuple

from hairpipe.bench.machine import Machine, this_machine

Echo = Callable[[str], None]
"""Takes a line on the progress of a bench."""
Case = dict[str, str | int | float | None]
"""What was measured, and its cost: values by column, whose name carries the unit."""


class Report(NamedTuple):
    """The result of a bench.

    module     of the bench
    tables     of cases, by name
    bandwidth  of memory, with most threads [GB/s]; None where it was not measured
    """

    module: str
    machine: Machine
    tables: dict[str, list[Case]]
    bandwidth: float | None = None


def make_report(module: str, tables: dict[str, list[Case]], bandwidth: float | None = None) -> Report:
    """Make the report of a bench on the machine at hand; tables without cases are left out."""
    return Report(module, this_machine(), {name: cases for name, cases in tables.items() if cases}, bandwidth)


def in_seconds(shares: dict[str, float], scale: float = 1.0, unit: str = "s") -> Case:
    """Lay the times of the parts of some work [s] out as columns, in another unit if one is given; pure."""
    return {f"{part} [{unit}]": scale * seconds for part, seconds in shares.items()}
