"""The project's own check of talus-gap on withheld effects: cases are drawn by seed from a bench twin that shares no
code with the library, their labels sealed, diagnosed, and the seal opened (docs/blind.md)."""
