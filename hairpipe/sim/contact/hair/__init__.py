"""Hair against hair, while a stage is solved."""
