"""Reading and writing of OpenVDB files without its library."""
