"""The equations as Bando, Chen, Nishita 2003 print them, where hair fails by them."""
