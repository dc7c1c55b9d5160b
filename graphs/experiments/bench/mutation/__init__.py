"""Mutation of the engine: small changes of its code, of which each should fail some test."""
