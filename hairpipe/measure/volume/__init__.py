"""Hair as a volume: its packing, its shell, and the density that it is led to."""
