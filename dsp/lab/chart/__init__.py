"""Pictures of accuracy against cost, drawn by `carom chart`."""
