"""The files that a server writes: recordings and logs."""
