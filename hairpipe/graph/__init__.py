"""The engine: graph files, node declarations, keys, store, plan and run. It knows nothing of hair."""
