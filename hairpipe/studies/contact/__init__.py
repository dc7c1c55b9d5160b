"""How contact between hairs is solved, and how well."""
