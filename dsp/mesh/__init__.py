"""Models of bodies from triangle meshes: their modes, the shapes of these at points of the surface, and their sound.

`cleaned` mends a mesh; `model_of` computes. Solids and thick sheets are finite cells, thin walls are shell elements.
numpy and scipy alone; no input or output. scipy is slow to load, so nothing here is imported before it is requested.
"""
