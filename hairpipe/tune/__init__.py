"""Which model a scene needs: what each simplification costs in accuracy and saves in time, measured on the scene."""
