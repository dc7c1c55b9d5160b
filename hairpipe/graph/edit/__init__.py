"""Edits of the text of a graph file: comments, order and layout are kept."""
