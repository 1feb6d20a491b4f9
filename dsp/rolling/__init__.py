"""A body that rolls: the surface, the path over it, and the contacts on the way."""
