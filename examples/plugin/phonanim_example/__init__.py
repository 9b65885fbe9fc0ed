"""Parts for phonanim: a reader, an exporter and a regressor."""
