"""What every stage uses: files, tables, typing, threads, the catalog of models."""
