"""Rules for the composition of a stage: validators of OpenUSD, and rules of ours where it has none."""
