"""The source paper's experiment on the bench twin, as one page: `make paper`, docs/paper.md."""
