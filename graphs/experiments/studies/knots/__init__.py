"""A strand that touches itself: an overhand knot, and a twisted strand that has coiled up, compared with rod theory."""
