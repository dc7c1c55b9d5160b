"""Cost of the code: times, limits of the machine, and machine code."""
