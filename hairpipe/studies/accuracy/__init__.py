"""How far the network of a strand is from the elastic rod it stands for; one measured quantity a file."""
