"""A discrete elastic rod: bending and twist at its vertices, stretch on its edges, four unknowns a segment."""
