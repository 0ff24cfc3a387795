"""Three-axis machining centre with flexible axes."""
