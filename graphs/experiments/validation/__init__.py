"""Validation: errors against independent truths, compared with what is allowed."""
