"""The page that shows a graph and what it made: served by `hairpipe view`, frozen by `hairpipe report`."""
