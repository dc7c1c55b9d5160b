"""Commands for the cache, for files and for this machine, one per module, imported on demand."""
