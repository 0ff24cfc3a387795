"""H-infinity and gain-scheduled (LPV) synthesis; knows no drive.

What is designed for is a ``GeneralisedPlant`` or a function that gives one at each
value ρ of the scheduling parameters.
"""
