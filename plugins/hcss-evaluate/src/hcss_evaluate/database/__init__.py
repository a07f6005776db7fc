"""Database of clouds that are cut from images: import, cleaning of masks, measured samples."""
