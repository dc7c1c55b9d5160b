"""Find the cheapest model of a scene within a tolerance, from errors and times measured on the scene."""
