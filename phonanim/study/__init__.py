"""User studies: takes side by side in a web page of one file, and what the answers say."""
