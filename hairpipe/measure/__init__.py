"""What hair is doing, as numbers."""
