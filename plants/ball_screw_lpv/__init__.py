"""Ball screw whose dynamics vary with nut position and workpiece mass."""
