"""The spectral bank: modes that ring freely, computed a block of 512 frames at a time."""
