"""Published figures beside ours, study by study."""
