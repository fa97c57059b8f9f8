"""From flown bags to plant models."""
