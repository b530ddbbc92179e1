/* fake_stamps.c: preloaded, it gives every interface a clock that can stamp frames, as no virtual one has, for a test of what is
 * asked of the driver. What an interface is set to stands in the file $FAKE_STAMPS/INDEX: "TX_TYPE RX_FILTER". */
#define _GNU_SOURCE

#include <errno.h>
#include <linux/ethtool.h>
#include <linux/net_tstamp.h>
#include <linux/sockios.h>
#include <net/if.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/syscall.h>
#include <unistd.h>

static int setting(const struct ifreq *asked, int set) {
  struct hwtstamp_config *config = (struct hwtstamp_config *)asked->ifr_data;
  char path[4096];
  snprintf(path, sizeof path, "%s/%u", getenv("FAKE_STAMPS"), if_nametoindex(asked->ifr_name));
  FILE *file = fopen(path, set ? "r+" : "r");
  if (!file) return errno = ENODEV, -1;
  const int good = set ? fprintf(file, "%d %d\n", config->tx_type, config->rx_filter) > 0
                       : fscanf(file, "%d %d", &config->tx_type, &config->rx_filter) == 2;
  return fclose(file) == 0 && good ? 0 : -1;
}

int ioctl(int fd, unsigned long request, ...) {
  va_list arguments;
  va_start(arguments, request);
  void *data = va_arg(arguments, void *);
  va_end(arguments);
  const struct ifreq *asked = data;
  if (request == SIOCETHTOOL)
    return ((struct ethtool_ts_info *)(void *)asked->ifr_data)->so_timestamping =
               SOF_TIMESTAMPING_RX_HARDWARE,
                                            0;
  if (request == SIOCGHWTSTAMP || request == SIOCSHWTSTAMP) return setting(asked, request == SIOCSHWTSTAMP);
  return (int)syscall(SYS_ioctl, fd, request, data);
}
