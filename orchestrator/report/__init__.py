"""The HTML report of one run or of several laid over each other."""
