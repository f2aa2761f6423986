"""What an identification leaves behind: files, and text for people."""
