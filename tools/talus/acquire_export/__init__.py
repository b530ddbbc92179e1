"""talus-acquire export: a record of the bus becomes a recording. docs/talus-acquire-export.md, docs/bus.md."""
