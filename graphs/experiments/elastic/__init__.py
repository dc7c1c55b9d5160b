"""Springs on tetrahedral meshes and on shells: Sec. 3.1 of Selle, Lentine, Fedkiw 2008 away from hair."""
