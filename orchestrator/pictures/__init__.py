"""Pictures of a composition as SVG: its wiring and its timetable."""
