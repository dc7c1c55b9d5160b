"""Edits of the graph file of a page, their history, and the files of its project."""
