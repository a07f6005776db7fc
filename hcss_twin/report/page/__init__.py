"""Self-contained web pages: what all HTML reports are made of."""
