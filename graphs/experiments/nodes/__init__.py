"""Node types of the experiments, one a file: found by the graphs next to this folder."""
