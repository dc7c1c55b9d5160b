"""OpenVDB: reading and writing of voxel files without its library."""
