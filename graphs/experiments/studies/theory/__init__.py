"""The elastic rod: the theory that the hair is measured against; it knows nothing of the spring network."""
