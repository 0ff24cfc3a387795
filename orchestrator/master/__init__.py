"""The co-simulation master: wires, orders, schedules, carries out, records a system."""
