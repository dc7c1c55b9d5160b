"""Kinds of hair as settings of `simulate_hair`: each value is physical, and each kind is explained.

Bending stiffness grows with the fourth power of the diameter. Hairs that slide on one another bend each by itself: a
bundle of n hairs of diameter d is a rod of diameter n^(1/2) d, with the n-th part of Young's modulus.
"""

from typing import Any

from .settings import set_values

CONTACT: dict[str, Any] = {"stiction": {}, "collisions": {}}
PRESETS: dict[str, tuple[str, str, dict[str, Any]]] = {
    "MEDIUM": ("Medium hair", "80 um thick, as most scalp hair; hairs touch and cling", CONTACT),
    "FINE": (
        "Fine hair",
        "55 um thick: bends 4.5 times as easily as medium hair",
        CONTACT | {"material": {"diameter": 55e-6}},
    ),
    "COARSE": (
        "Coarse hair",
        "105 um thick: three times as stiff as medium hair",
        CONTACT | {"material": {"diameter": 105e-6}},
    ),
    **{
        name.upper(): (
            f"{name} hair",
            f"Measured area and ellipticity of {name} hair; twists twice as easily as an isotropic fibre",
            CONTACT | {"material": material},
        )
        for name, material in (
            ("Asian", {"poisson": 1.26}),
            ("European", {"diameter": 72e-6, "poisson": 1.32}),
            ("African", {"diameter": 73e-6, "poisson": 1.47}),
        )
    },
    "WET": (
        "Wet hair",
        "Water makes hair heavier and softer, and holds hairs together from a larger distance",
        {
            "stiction": {"reach": 1e-3, "release": 3e-3, "force": 1e-5},
            "collisions": {},
            "material": {"density": 1700.0, "young": 1.6e9},
        },
    ),
    "FUR": (
        "Short fur",
        "Short hair that hardly touches: no contact among hairs; a pull at 4 Hz holds the shape of the groom",
        {"goal": {}},
    ),
    "BRAID": (
        "Braid",
        "Each curve stands for a bundle of 625 hairs, 2 mm thick, that slide on one another; bundles touch",
        {"material": {"diameter": 2e-3, "young": 3.9e9 / 625}, "collisions": {"thickness": 2e-3}},
    ),
}
"""Name, explanation and settings; all others have their defaults."""
ITEMS = [(key, name, about) for key, (name, about, _) in PRESETS.items()]


def apply(properties: Any) -> None:
    """Set the settings of the simulation of an object to those of its preset."""
    from .properties import shown_settings

    set_values(properties.simulation, shown_settings("simulation"), PRESETS[properties.preset][2])
