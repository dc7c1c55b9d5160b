"""Rules for the composition of a stage: validators of OpenUSD, and our rules in addition."""
