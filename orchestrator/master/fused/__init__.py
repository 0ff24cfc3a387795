"""Our FMUs of a system as one compiled loop, for one run or for many in lanes."""
