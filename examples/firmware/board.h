/* board.h: what the example needs of a machine: a word out, and what a call costs. */
#ifndef BOARD_H
#define BOARD_H

#include <stdint.h>

void board_start(void);
/* The fewest and the most ticks of SysTick that one call of the controller took; 0 where nothing counts. */
void board_counts(uint32_t *least, uint32_t *most);
void board_report(const char *name, uint32_t value); /* in hexadecimal */
void board_end(void);

#endif
