"""The edge: codecs that see bytes, ports that move them."""
