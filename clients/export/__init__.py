"""Scenes that play without Python: baked, and written as a web page."""
