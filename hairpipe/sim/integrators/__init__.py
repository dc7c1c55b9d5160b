"""How forces are carried through a step of time."""
