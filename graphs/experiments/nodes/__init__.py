"""Node types of the experiments, one a file: found by the graphs beside this folder."""
