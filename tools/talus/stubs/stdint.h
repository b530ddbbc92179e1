/* stdint.h for the Python side: cffi knows these types by itself. */
