"""The commands on graphs and their results, imported when called."""
