"""Carom: hear bodies hit, bounce and roll."""
