"""Built-in providers; they implement the same provider contract as third-party plugins."""
