"""The output file: one table of variables drives writer, reader, docs and tests."""
