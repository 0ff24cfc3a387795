"""C of the orchestrator, compiled once: the kernel, the channel between processes."""
