"""Pictures of a nappe run, from the files in its folder (docs/output.md)."""
