"""What a run is judged by: metrics, expectations, where a signal is worst."""
