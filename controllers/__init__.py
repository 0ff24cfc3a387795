"""One module per run-time controller, feed-forward, filter or trajectory generator."""
