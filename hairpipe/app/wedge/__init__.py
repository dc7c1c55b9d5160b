"""Wedges: variants of a graph in a table, and on a contact sheet."""
