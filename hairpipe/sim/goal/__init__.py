"""Goals: forces that pull hair to places carried by the skin, or by another body."""
