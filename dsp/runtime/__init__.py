"""The engine from Python: memory, the compiled callback, the devices and clocks that call it."""
