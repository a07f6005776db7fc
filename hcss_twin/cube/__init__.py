"""The output file: one table of variables is shared by writer, reader, docs and tests."""
