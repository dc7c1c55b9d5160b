"""Tunes many scenes: whether promises are kept, on scenes that are drawn at random, and what scenes need."""
