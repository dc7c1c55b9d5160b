"""Values painted on a body, and settings that vary from strand to strand and along strands."""
