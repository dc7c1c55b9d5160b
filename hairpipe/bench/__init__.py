"""What the code costs: times, what the machine could do, and what machine code came out."""
