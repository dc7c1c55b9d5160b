"""Universal Scene Description: bodies and grooms in, shots out, and a strict check of shots."""
