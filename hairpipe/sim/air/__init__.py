"""Wind: what moving air does to hair, how it gusts, and how hair shields hair."""
