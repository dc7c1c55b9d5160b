"""One law a file: force, derivative, source and cost."""
