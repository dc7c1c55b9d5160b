"""Finds the model a scene needs: error and time of each simplification, measured on the scene."""
