"""Quick pictures of hair and body, drawn in software: what a flipbook shows."""
