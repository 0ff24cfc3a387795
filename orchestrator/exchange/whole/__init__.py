"""A composition as one FMU, its timetable and our models compiled in."""
