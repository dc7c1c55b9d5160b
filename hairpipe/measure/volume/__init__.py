"""Hair as a volume: its packing."""
