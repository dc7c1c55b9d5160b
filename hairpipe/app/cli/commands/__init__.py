"""The commands on graphs and their results, one a module, imported when called."""
