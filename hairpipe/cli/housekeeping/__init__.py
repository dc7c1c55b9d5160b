"""The commands on the cache, on files and on this machine, one a module, imported when called."""
