"""Rules for how a stage is put together."""
