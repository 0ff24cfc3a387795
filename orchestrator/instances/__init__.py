"""One FMU while it runs: in this process, ticked by a clock, integrated, or apart."""
