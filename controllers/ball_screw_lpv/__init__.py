"""Controllers of the ball screw whose dynamics vary with nut and workpiece."""
