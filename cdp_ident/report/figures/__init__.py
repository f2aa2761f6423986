"""The pictures of a report: what each shows, said once, and how it is drawn for a page and for a paper."""
