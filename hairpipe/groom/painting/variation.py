"""Settings that vary from strand to strand and along strands."""

from typing import Any, get_type_hints

import numpy as np

from hairpipe.data import Groom
from hairpipe.data.curves import labels_of
from hairpipe.data.lengths import fractions_along
from hairpipe.errors import BadInput
from hairpipe.groom.binding import name_strands
from hairpipe.groom.painting.paint import ReadImage, sample_image
from hairpipe.groom.painting.painted import Profile, Varied, VariedWidth
from hairpipe.groom.random_streams import chances
from hairpipe.groom.sampling import members_of


def values_of(setting: Varied | float, groom: Groom, name: str, read_image: ReadImage | None = None) -> Any:
    """Return the number that a setting is everywhere, or its values at points and on the segments after them, (2, P).

    name  of the setting, for messages

    The value on a segment is that at its middle; that after the last point of a strand is of no segment.

    Raises BadInput where the groom does not carry what the setting names, and for values out of range.
    """
    if not isinstance(setting, Varied):
        return setting
    if setting.is_constant:
        return setting.value
    strands = np.repeat(np.arange(len(groom.ids)), np.diff(groom.offsets))
    along = fractions_along(groom.points, groom.offsets)
    along = np.stack([along, _at_middles(along)])
    along[1, groom.offsets[1:] - 1] = 1.0
    values = _nominal(setting, groom, name)
    paint = _paint(setting, groom, name, read_image)
    if paint is not None:
        values = setting.low + (values - setting.low) * paint[strands]
    factors = _group_factors(setting, groom, name)
    factors *= 1.0 + setting.variation * chances(0, name, groom.ids)
    values = values * factors[strands] * np.ones_like(along)
    values = values * factors_along(setting.profile, along, f"{name}.profile")
    _check_range(values, setting, groom.ids[strands], name)
    return values


def factors_along(profile: Profile, fractions: np.ndarray, where: str) -> np.ndarray:
    """Return the factors of a profile at fractions of the length; BadInput where those of the profile do not ascend."""
    if not profile:
        return np.ones_like(fractions)
    places, factors = np.array(profile).T
    if (np.diff(places) <= 0.0).any():
        raise BadInput("fractions that do not ascend", where=where, right="[[0.0, 1.0], [1.0, 0.2]]")
    return np.interp(fractions, places, factors)


def _nominal(setting: Varied, groom: Groom, name: str) -> Any:
    """Return the value before map and factors: a number, or the widths of the groom as `values_of`."""
    if not isinstance(setting, VariedWidth) or setting.widths is None:
        return setting.value
    if groom.widths is None:
        raise BadInput("the groom carries no widths", where=name, right="a number, or a groom of a file with widths")
    return setting.widths * np.stack([groom.widths, _at_middles(groom.widths)])


def _at_middles(values: np.ndarray) -> np.ndarray:
    """Return the mean of each of the values, (P,), and the next; of the last its own."""
    return np.append(0.5 * (values[:-1] + values[1:]), values[-1])


def map_of(groom: Groom, name: str, where: str) -> np.ndarray:
    """Return a map of the groom by its name, or a group as 1 on its strands and 0 elsewhere, (S,); BadInput without."""
    labels = np.empty(0, str) if groom.groups is None else labels_of(groom.groups, groom.group_names)
    found = groom.maps.get(name)
    if found is None and name in labels:
        return members_of(groom, (name,), where).astype(float)
    if found is None:
        known = [*sorted(groom.maps), *np.unique(labels).tolist()]
        right = ", ".join(f"'{each}'" for each in known) or "a groom with maps or groups: this one has none"
        raise BadInput(f"the groom carries no map or group '{name}'", where=where, right=right)
    if found.shape != groom.ids.shape:
        what = f"the map '{name}' of the groom has shape {found.shape}"
        raise BadInput(what, where=where, right=f"a value for each of {len(groom.ids)} strands")
    return found


def _paint(setting: Varied, groom: Groom, name: str, read_image: ReadImage | None) -> np.ndarray | None:
    """Return the map or image of a setting at the strands, (S,); None without."""
    if setting.map is not None and setting.image is not None:
        raise BadInput("both a map and an image are given", where=name, right="one of the two")
    if setting.map is not None:
        return map_of(groom, setting.map, name)
    if setting.image is None:
        return None
    if read_image is None or not groom.root_uv.any():
        raise BadInput("the roots have no texture coordinates for an image", where=name, right="a map")
    return sample_image(setting.image, read_image, groom.root_uv.astype(float), name)


def _group_factors(setting: Varied, groom: Groom, name: str) -> np.ndarray:
    """Return the factor of the group of each strand, (S,)."""
    factors = np.ones(len(groom.ids))
    for group, factor in setting.groups:
        factors *= np.where(members_of(groom, (group,), f"{name}.groups"), factor, 1.0)
    return factors


def _check_range(values: np.ndarray, setting: Varied, ids: np.ndarray, name: str) -> None:
    """Refuse values out of the range of the setting; ids  of the strands of points, (P,)."""
    unit, interval = get_type_hints(type(setting), include_extras=True)["value"].__metadata__
    wrong = ~((values >= interval.ge) & (values <= interval.le))
    if wrong.any():
        worst = values[wrong][0]
        strands = np.unique(ids[wrong.any(axis=0)])
        right = f"{interval.ge:g} to {interval.le:g} {unit.symbol} everywhere, as value, low, profile and maps make it"
        raise BadInput(f"{name} is {worst:.3g} {unit.symbol}: {name_strands(strands)}", where=name, right=right)
