"""talus-fleet: one diagnosis a recording for thousands of recordings, and what they say together (docs/talus-fleet.md)."""
