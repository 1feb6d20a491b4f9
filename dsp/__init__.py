"""Carom's signal processing: contact -> modes -> mix, pure and without input or output."""
