"""From a mesh to a level set."""
