"""The reference face: shape modes, appearance, masks and lip contacts."""
