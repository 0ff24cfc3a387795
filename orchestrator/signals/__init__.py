"""Recorded signals: read from files, put on the ticks of a run, made an FMU."""
