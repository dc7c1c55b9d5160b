"""A shot of strands: settings, scene, frame, cuts, locks."""
