"""The whole identification, from bags to the files of its report."""
