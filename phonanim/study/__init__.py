"""User studies: pairs of videos in a one-file web page, and the analysis of the answers."""
