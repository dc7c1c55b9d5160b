"""What is chosen, on tables that are made up."""

import math
from dataclasses import replace
from itertools import product

import pytest

from hairpipe.app.tune.measured import Measured, failed
from hairpipe.app.tune.tuning import WORTH, choose, choose_within, leaves_out_as_much
from hairpipe.values.simplification import Simplification

AXES = {"model": 1, "segments": 3, "steps": 3, "collisions": 1}
PARTS = [
    Simplification(axis, level, f"{axis} {level}") for axis, count in AXES.items() for level in range(1, count + 1)
]


def found(bound: float, seconds: float) -> Measured:
    return Measured(bound, bound, seconds, bound, bound, bound)


FULL = found(0.1, 10.0)


class World:
    """A scene: what each part adds to the squared error and leaves of the time, and how parts get on together.

    together  factor on the error of what leaves out more than one thing
    """

    def __init__(self, together: float = 1.0, worse: float = 0.5) -> None:
        self.together, self.worse = together, worse
        self.asked = []

    def measure(self, parts) -> Measured:
        self.asked.append(parts)
        return self.truth(parts)

    def truth(self, parts) -> Measured:
        square = 0.01 + sum((self.worse * part.level**1.5) ** 2 for part in parts)
        bound = math.sqrt(square) * (self.together if len(parts) > 1 else 1.0)
        return found(bound, 10.0 * math.prod(0.8 ** (part.level + (part.axis == "model")) for part in parts))

    def singles(self) -> dict[Simplification, Measured]:
        return {part: self.truth([part]) for part in PARTS}

    def everything(self):
        """All combinations."""
        levels = [[None, *(p for p in PARTS if p.axis == axis)] for axis in AXES]
        return [frozenset(p for p in picked if p) for picked in product(*levels)]


@pytest.mark.parametrize("tolerance", [0.3, 0.6, 1.0, 2.0, 4.0, 9.0])
def test_where_squares_add_the_cheapest_of_all_is_found_with_one_measurement(tolerance):
    world = World()
    choice = choose(FULL, world.singles(), tolerance, world.measure)
    within = [world.truth(parts).seconds for parts in world.everything() if world.truth(parts).bound <= tolerance]
    assert choice.measured.seconds == pytest.approx(min(within))
    assert len(world.asked) <= 1


@pytest.mark.parametrize("together", [0.5, 1.5, 3.0, 30.0])
@pytest.mark.parametrize("tolerance", [0.3, 1.0, 3.0])
def test_the_chosen_combination_was_measured_and_keeps_the_tolerance(together, tolerance):
    world = World(together)
    choice = choose(FULL, world.singles(), tolerance, world.measure)
    assert choice.parts is not None and choice.measured.bound <= tolerance
    assert choice.measured == (world.truth(choice.parts) if choice.parts else FULL)
    assert len(choice.parts) <= 1 or choice.parts in world.asked
    assert len({part.axis for part in choice.parts}) == len(choice.parts)


def cheapest_single(world: World, tolerance: float) -> Measured:
    return min((found for found in world.singles().values() if found.bound <= tolerance), key=lambda one: one.seconds)


def test_incompatible_simplifications_leave_the_best_single_one():
    world = World(together=30.0)
    assert choose(FULL, world.singles(), 1.0, world.measure).measured == cheapest_single(world, 1.0)


def test_nothing_is_tried_that_goes_as_far_as_what_failed():
    world = World(together=3.0)
    choose(FULL, world.singles(), 3.0, world.measure)
    failed_before = []
    for parts in world.asked:
        assert not any(leaves_out_as_much(parts, other) for other in failed_before)
        failed_before += [parts] if world.truth(parts).bound > 3.0 else []
    assert failed_before


def test_without_time_one_combination_is_measured_and_the_best_so_far_is_chosen():
    world = World(together=30.0)
    choice = choose(FULL, world.singles(), 1.0, world.measure, lambda: False)
    assert len(world.asked) == len(choice.trials) == 1
    assert choice.measured == cheapest_single(world, 1.0)
    assert len(choose(FULL, world.singles(), 1.0, world.measure).trials) > 1


@pytest.mark.parametrize("together", [0.5, 1.5, 30.0])
@pytest.mark.parametrize("worst", [0.0, 0.2, 0.5, 1.0])
def test_the_cheapest_that_passes_the_check_is_chosen(together, worst):
    """In the check all errors are larger; what leaves out as much as one that fails there is not looked at."""
    world, checked = World(together), []

    def passes(parts) -> bool:
        checked.append(parts)
        return world.truth(parts).bound <= worst or not parts

    choice = choose(FULL, world.singles(), 1.0, world.measure, passes=passes)
    assert choice.parts is not None and (not choice.parts or world.truth(choice.parts).bound <= worst)
    assert set(choice.failed) <= set(checked) and choice.parts not in choice.failed
    for at, parts in enumerate(choice.failed):
        assert not any(leaves_out_as_much(later, parts) for later in choice.failed[at + 1 :])
    assert choice.failed or worst > 0.4


def test_unmet_tolerance_is_reported_with_the_nearest_model():
    world = World()
    choice = choose(FULL, world.singles(), 0.05, world.measure)
    assert choice.parts is None and choice.measured == FULL and not world.asked


def test_a_model_nearer_by_chance_useless_or_failed_is_not_chosen():
    lucky = {PARTS[0]: found(0.01, 5.0)}
    assert choose(FULL, lucky, 0.05, World().measure).parts is None
    choice = choose(FULL, World(worse=5.0).singles(), 1.0, World().measure)
    assert choice.parts == frozenset() and choice.measured == FULL
    idle, broken = Simplification("voxels", 1, "voxels of 8 mm"), Simplification("model", 2, "broken")
    singles = {idle: found(0.1, 10.0 * (WORTH + 0.01)), broken: failed("blew up")}
    assert choose(FULL, singles, 1.0, World().measure).parts == frozenset()


def test_physics_without_effect_is_omitted_whatever_its_measured_time():
    idle = Simplification("stiction", 1, "no stiction", drops=("hair.stiction",))
    fewer = Simplification("segments", 1, "10 segments")
    singles = {idle: found(0.1, 10.5), fewer: found(0.5, 5.0)}
    choice = choose(FULL, singles, 1.0, lambda parts: found(0.5, 4.9))
    assert choice.parts == {idle, fewer}


def test_the_order_of_the_table_does_not_matter():
    singles = World().singles()
    other = dict(reversed(singles.items()))
    assert choose(FULL, singles, 2.0, World(1.3).measure).parts == choose(FULL, other, 2.0, World(1.3).measure).parts


@pytest.mark.parametrize("budget", [9.0, 6.0, 3.0])
def test_a_budget_buys_the_least_error_for_its_price(budget):
    world = World()
    choice = choose_within(FULL, world.singles(), budget, world.measure)
    affordable = [world.truth(parts).bound for parts in world.everything() if world.truth(parts).seconds <= budget]
    assert choice.measured.seconds <= budget and choice.measured.bound == pytest.approx(min(affordable))


def test_unmet_budget_is_reported_with_the_cheapest_model():
    world = World()
    choice = choose_within(FULL, world.singles(), 1e-3, world.measure)
    assert choice.parts is None and len(world.asked) == 1
    assert choice.measured.seconds == pytest.approx(min(world.truth(parts).seconds for parts in world.everything()))


def test_exclusive_simplifications_are_not_combined():
    """Everything together would be cheaper; particles leave nothing of what else is left out, but for the voxels."""
    voxels = Simplification("voxels", 1, "voxels")
    alone = Simplification("particles", 1, "particles", instead="other:model", count=500, compatible=("voxels",))
    singles = {part: found(0.2, 5.0) for part in (*PARTS, voxels)} | {alone: found(0.2, 0.5)}
    world = World()
    choose(FULL, singles, 1.0, world.measure)
    assert world.asked == [frozenset({alone, voxels})]


class Chaotic(World):
    """A scene in which parts of an axis are told apart afterwards, and one was only screened."""

    def truth(self, parts) -> Measured:
        significant = any(part.axis == "collisions" for part in parts)
        return replace(super().truth(parts), refused="told apart: contacts" if significant else "")

    def singles(self) -> dict[Simplification, Measured]:
        return {
            part: replace(found, screened=part.axis == "model" and not found.refused)
            for part, found in super().singles().items()
        }


@pytest.mark.parametrize("tolerance", [0.6, 2.0])
def test_significant_or_screened_models_are_not_chosen(tolerance):
    world = Chaotic()
    choice = choose(FULL, world.singles(), tolerance, world.measure)
    assert choice.parts and not choice.measured.refused and not choice.measured.screened
    assert all(part.axis != "collisions" for part in choice.parts)
    assert len(choice.parts) > 1 or choice.parts in world.asked or next(iter(choice.parts)).axis != "model"


def test_significant_full_model_gives_no_choice():
    world, full = Chaotic(), replace(FULL, refused="told apart: strain")
    choice = choose(full, world.singles(), 2.0, world.measure)
    assert choice.parts is None and choice.measured == full and not world.asked
