"""Open benchmark of thermal radiance above clouds in three dimensions: cases as files, models, scores."""
