"""The project's own checks of talus-gap where it is known what there is to find: simulated benches that hide nothing (docs/nulls.md),
real recordings with an effect added to them (docs/spike.md), effects of one real recording on the others (docs/across.md), benches with and without a camera (docs/camera.md), and recordings with
a fault (docs/gate.md)."""
