"""Dry friction against modes: where it sticks, where it slips, and when it changes from one to the other."""
