"""The strict lint of shots: usd-core ships no validator that sees broken hair."""
