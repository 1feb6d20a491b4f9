"""The modal bank: modes that ring and are driven."""
