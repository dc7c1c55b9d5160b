"""What a strand is made of: particles, constants, and the forces between them. Every model fills the same interface."""
