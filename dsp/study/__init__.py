"""The laboratory: what sampled methods do where the closed forms are exact. The engine knows nothing of it."""
