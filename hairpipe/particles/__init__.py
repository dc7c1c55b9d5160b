"""Hair as loosely connected particles, after Bando, Chen, Nishita 2003."""
