"""The code that a result depends on."""
