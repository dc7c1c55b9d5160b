"""Particles drawn as billboards, after Bando, Chen, Nishita 2003, Sec. 5."""
