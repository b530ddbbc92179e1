/* board_cortex_m.c: start-up, semihosting and SysTick of a Cortex-M, for QEMU's mps2-an386 and microbit.
 *
 * QEMU with -icount shift=10 lets each instruction take 1024 ns; SysTick counts the processor's clock, so that
 * instructions are its ticks times TICK_NS / 1024 (docs/controller.md).
 */
#include "board.h"

#define SYSTICK ((volatile uint32_t *)0xE000E010)
#define COPROCESSORS (*(volatile uint32_t *)0xE000ED88)
#define TICK_MASK 0xFFFFFFU

extern uint32_t data_begin, data_end, data_image, bss_begin, bss_end, stack_top;
int main(void);

/* semihosting: operation in r0, its argument in r1 */
static void call(int operation, const void *argument) {
  register int r0 __asm__("r0") = operation;
  register const void *r1 __asm__("r1") = argument;

  __asm__ volatile("bkpt 0xAB" : "+r"(r0) : "r"(r1) : "memory");
}

void board_start(void) {
  SYSTICK[1] = TICK_MASK;
  SYSTICK[2] = 0;
  SYSTICK[0] = 5; /* on, from the processor's clock, no interrupt */
}

/* The linker puts this in the place of the controller's call (--wrap), so that the call alone is counted; `build` says
 * which of the three scalars it is. Reading the counter twice takes 4 instructions, which stay in. */
#define PASTE(a, b) a##b
#define WRAPPED(name) PASTE(__wrap_, name)
#define REAL_ONE(name) PASTE(__real_, name)
void REAL_ONE(COUNTED)(const void *c, void *state, const void *in, void *out);
void WRAPPED(COUNTED)(const void *c, void *state, const void *in, void *out);

static uint32_t least_ticks = TICK_MASK, most_ticks;

void WRAPPED(COUNTED)(const void *c, void *state, const void *in, void *out) {
  uint32_t count = SYSTICK[2];

  REAL_ONE(COUNTED)(c, state, in, out);
  count = (count - SYSTICK[2]) & TICK_MASK;
  least_ticks = count < least_ticks ? count : least_ticks;
  most_ticks = count > most_ticks ? count : most_ticks;
}

void board_counts(uint32_t *least, uint32_t *most) {
  *least = least_ticks;
  *most = most_ticks;
}

void board_report(const char *name, uint32_t value) {
  char text[12] = " ";
  int i;

  for (i = 0; i < 8; i++) text[1 + i] = "0123456789abcdef"[value >> (28 - 4 * i) & 15];
  text[9] = '\n';
  call(4, name); /* SYS_WRITE0 */
  call(4, text);
}

void board_end(void) {
  call(0x18, (const void *)0x20026); /* SYS_EXIT, ADP_Stopped_ApplicationExit */
  for (;;) {
  }
}

void reset(void) {
  const uint32_t *from = &data_image;
  uint32_t *to;

#if defined(__ARM_FP)
  COPROCESSORS |= 15U << 20;
#endif
  for (to = &data_begin; to < &data_end;) *to++ = *from++;
  for (to = &bss_begin; to < &bss_end;) *to++ = 0;
  (void)main();
}

static void trap(void) {
  board_report("trap", 0);
  board_end();
}

typedef void (*handler)(void);
__attribute__((section(".vectors"), used)) static const handler vectors[16] = {
    (handler)(void *)&stack_top, reset, trap, trap, trap, trap, trap, 0, 0, 0, 0, trap, trap, 0, trap, trap,
};
