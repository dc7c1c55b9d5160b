"""The hair: forces, filters, integrators, contact."""
