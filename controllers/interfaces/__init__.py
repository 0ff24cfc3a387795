"""Between signals in SI units and the objects of bus interfaces of drives."""
