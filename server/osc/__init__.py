"""OSC and its forms: packets, patterns, streams, addresses, scores, OSCQuery."""
