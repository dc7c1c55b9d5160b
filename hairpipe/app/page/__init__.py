"""Page of a graph and its results: served by `hairpipe view`, written by `hairpipe report`."""
