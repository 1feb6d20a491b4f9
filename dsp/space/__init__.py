"""Space: sound that takes its time, from a place to a listener, a head, a sphere of directions, a room."""
