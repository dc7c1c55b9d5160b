"""Measures of hair that only experiments take."""
