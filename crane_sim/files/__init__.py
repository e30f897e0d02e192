"""What people write and read: scene documents, tables, types of values, errors of one line."""
