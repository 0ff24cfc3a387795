"""The local page of ``feeddrive serve``: compose, run, compare.

Only ``server`` knows the web framework, an extra of the package; the other modules
turn what the rooms below return into JSON and frames of numbers.
"""
