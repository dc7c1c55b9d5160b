"""What pictures and pages cost."""
