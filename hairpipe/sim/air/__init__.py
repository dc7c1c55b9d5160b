"""Wind: drag, gusts, and shielding of hair by hair."""
