"""A node pipeline for hair: graph file in, USD curves and OpenVDB level sets out."""

__version__ = "0.1.0"
