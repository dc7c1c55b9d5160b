"""Wedges to look at: the variants of a graph in a table, and on a contact sheet."""
