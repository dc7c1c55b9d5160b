"""Time integrators: one scheme per file, each built of the stages of `implicit_stage.py`."""
