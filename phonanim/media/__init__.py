"""Sound, film, pictures and binary glTF."""
