"""Rules for the body and for the roots on it."""
