"""Questions that a benchmark answers once: each file says which."""
