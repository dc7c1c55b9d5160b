"""Who is near whom: trees, pair searches and distances of segments and triangles."""
