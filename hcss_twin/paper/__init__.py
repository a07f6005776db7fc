"""The published tables and figures, computed again and laid beside what is printed."""
