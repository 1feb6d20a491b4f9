"""The server over HTTP and web sockets: the page, OSCQuery, OSC in binary frames, and the sound itself."""
