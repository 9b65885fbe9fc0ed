"""What every stage stands on: files, tables, typing, threads, the catalog of models."""
