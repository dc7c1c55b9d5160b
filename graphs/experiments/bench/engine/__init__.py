"""Cost of the engine: tasks, frames, first use, traffic."""
