"""How hair, skin and scalp throw light back."""
