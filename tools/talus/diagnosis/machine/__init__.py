"""The machine beside the effects: as its model file draws it, in physical parameters, and with springs that can be."""
