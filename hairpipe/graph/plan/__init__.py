"""What a run would do, and why; what may go from the store."""
