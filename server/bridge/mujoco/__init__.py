"""MuJoCo as it is: its structs and functions in its own memory, and what of its models sounds."""
