"""Element providers: things in the scene besides clouds and sea."""
