/* uml_xstate.c: preloaded into the UML kernel on processors whose register state is larger than it knows.
 *
 * The kernel writes a process's floating-point registers back by PTRACE_SETREGSET with a buffer of 2.7 KiB.
 * A host whose processor has AMX tiles demands its full 11 KiB and answers EFAULT, and the guest dies at its
 * first process. So: what is written back is put over the full state as it stands. Guest programs use no tiles.
 */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <stdarg.h>
#include <string.h>
#include <sys/ptrace.h>
#include <sys/types.h>
#include <sys/uio.h>

enum { NT_X86_XSTATE = 0x202, LARGEST = 65536 };

long ptrace(enum __ptrace_request request, ...) {
  static long (*next)(enum __ptrace_request, ...);
  static char full[LARGEST];
  struct iovec whole = {full, sizeof full};
  va_list arguments;

  va_start(arguments, request);
  const pid_t pid = va_arg(arguments, pid_t);
  void *address = va_arg(arguments, void *);
  struct iovec *given = va_arg(arguments, void *);
  va_end(arguments);
  if (!next) next = (long (*)(enum __ptrace_request, ...))dlsym(RTLD_NEXT, "ptrace");
  if (request != PTRACE_SETREGSET || (size_t)address != NT_X86_XSTATE)
    return next(request, pid, address, given);
  if (next(PTRACE_GETREGSET, pid, address, &whole) != 0) return -1;
  memcpy(full, given->iov_base, given->iov_len < whole.iov_len ? given->iov_len : whole.iov_len);
  return next(PTRACE_SETREGSET, pid, address, &whole);
}
