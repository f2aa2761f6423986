"""The report as a page for a browser and as a text for version control."""
