"""What can be wrong with a folder."""


class BadRun(Exception):
    """The folder is no run, or a file in it is not what it should be."""
