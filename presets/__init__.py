"""Built-in presets: materials, objects and strikers as TOML files, scores as text."""
