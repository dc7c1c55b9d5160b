"""Errors of hair that is chaotic: small ensembles of runs in place of one against another."""
