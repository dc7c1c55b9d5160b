"""Files of strands without a body: HAIR, USC-HairSalon, reconstructions, lines of OBJ and PLY, TressFX."""
