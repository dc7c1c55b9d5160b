"""Our own body, made by code."""
