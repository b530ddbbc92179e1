/* fake_can.c: preloaded, it is a CAN socket for a kernel that has none, for tests of what happens when the kernel takes only some of an
 * emergency stop's frames. The first $FAKE_CAN_TAKES frames go into the file $FAKE_CAN, one behind the other; each later one fails with
 * the errno $FAKE_CAN_FAILS. Any interface may stand for the CAN interface. */
#define _GNU_SOURCE

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <unistd.h>

int socket(int domain, int type, int protocol) {
  const int is_can = domain == PF_CAN;
  const int flags = type & (SOCK_CLOEXEC | SOCK_NONBLOCK);
  return (int)syscall(SYS_socket, is_can ? AF_UNIX : domain, is_can ? SOCK_DGRAM | flags : type,
                      is_can ? 0 : protocol);
}

ssize_t sendto(int fd, const void *bytes, size_t n, int flags, const struct sockaddr *to, socklen_t size) {
  static int taken;
  if (!to || to->sa_family != AF_CAN) return syscall(SYS_sendto, fd, bytes, n, flags, to, size);
  if (taken >= atoi(getenv("FAKE_CAN_TAKES"))) {
    errno = atoi(getenv("FAKE_CAN_FAILS"));
    return -1;
  }
  taken++;
  const int file = open(getenv("FAKE_CAN"), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0600);
  const ssize_t written = write(file, bytes, n);
  close(file);
  return written;
}
