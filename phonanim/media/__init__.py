"""Audio, video, pictures and binary glTF."""
