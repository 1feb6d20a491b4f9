"""Von Karman's coupling of a plate's modes: its forces on a polar grid, and the step that keeps energy from growing."""
