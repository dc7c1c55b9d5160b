"""The strict lint of shots: validators of usd-core, and rules of ours, since it ships none that sees broken hair."""
