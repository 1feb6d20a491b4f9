"""Objects and strikers as the engine has them: their modes, their tension, and the voices of what strikes."""
