/* info.h: talus-acquire info: what a record holds, its gaps, clocks and rates. */
#ifndef INFO_H
#define INFO_H

/* The whole program behind the word; its exit status. */
int info_main(int argc, char **argv);

#endif
