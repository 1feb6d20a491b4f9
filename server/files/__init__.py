"""What a server writes: recordings and logs."""
