"""Carries out a plan: scheduler, workers, publishing."""
