"""A real image or sequence beside a simulated one."""
