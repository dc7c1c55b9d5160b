"""One foreign file format a file."""
