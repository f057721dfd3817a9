"""Published tables and claims beside ours, one file a paper."""
