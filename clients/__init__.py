"""Clients of the server: a Python client, the command line, and examples for other programs."""
