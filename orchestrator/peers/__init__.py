"""Other people's co-simulation tools, each run by a process of its own.

``child.py`` runs one tool's file in the Python that has the tool; nothing in
those files imports anything of ours, as that Python need not know us.
"""
