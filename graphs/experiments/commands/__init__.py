"""Commands of a checkout: results, validate, bench."""
