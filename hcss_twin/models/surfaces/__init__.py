"""Surface providers of this package: maps of land, sea and ice."""
