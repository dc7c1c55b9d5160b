"""Shape of hair: writhe, spread of a tuft, crossing of two locks."""
