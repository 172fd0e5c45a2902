"""The core as machine code for others: an object, a library, a C header and a host in C."""
