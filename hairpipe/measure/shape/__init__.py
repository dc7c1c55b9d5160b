"""The shape of hair: curls, writhe, how a tuft spreads and crosses another."""
