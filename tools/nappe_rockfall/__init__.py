"""The rockfall on an embankment (seeds/004), all of its runs and what they say."""
