"""Datagrams and streams in, replies out."""
