"""T-type gantry on linear motors: y axis with yaw, x axis, encoders."""
