"""Reports of benches: printed, recorded, and with the commit and machine that they come from."""
