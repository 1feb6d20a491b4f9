"""The way out: the mix, fades, the limiter and the meter."""
