"""The store: values and records on disk, whole or not at all."""
