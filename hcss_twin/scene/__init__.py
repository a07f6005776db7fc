"""The way of the data: plan, compile, stream."""
