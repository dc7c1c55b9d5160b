"""Tests of the store at every call of the file system."""
