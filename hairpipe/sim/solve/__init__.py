"""One implicit stage of all strands: assemble, factor, couple, solve."""
