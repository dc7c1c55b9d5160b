"""Motion-capture files."""
