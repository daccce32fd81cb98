"""The sections that all pages have, a module each."""
