"""Serial x-y machine of two ball-screw axes."""
