/* stdbool.h for the Python side: cffi knows these types by itself. */
#define bool _Bool
