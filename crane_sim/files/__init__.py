"""Files: scene documents, tables, types of values, single-line errors."""
