"""talus-gap's own search on problems whose answer theory has: linear, with Gaussian noise."""
