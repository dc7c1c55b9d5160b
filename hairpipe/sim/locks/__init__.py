"""Hair that moves together is simulated once: locks, their guides, and the hairs that are carried along."""
