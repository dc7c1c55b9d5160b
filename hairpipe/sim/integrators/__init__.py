"""How forces are carried through a step of time: one scheme a file, each built of the stages of `implicit_stage.py`."""
