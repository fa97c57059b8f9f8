"""Frames, messages, topics, time and the node runner that all packages share."""
