"""Views of an animation for people: the HTML page and the contact sheet."""
