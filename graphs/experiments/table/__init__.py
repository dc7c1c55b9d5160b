"""Tools for tables: rows, series, Pareto fronts."""
