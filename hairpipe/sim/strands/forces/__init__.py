"""Forces on a strand: each file adds one equation to the force vector and to the banded matrix."""
