/* talus-track: coloured markers in a video, and the camera's clock against the recording's. */
#include <string.h>

#include "track/commands.h"

static const struct {
  const char *name;
  int (*run)(int argc, char **argv);
} command[] = {{"calibrate", command_calibrate},
               {"lens", command_lens},
               {"tilt", command_tilt},
               {"align", command_align}};

int main(int argc, char **argv) {
  for (size_t i = 0; argc > 1 && i < sizeof command / sizeof command[0]; i++)
    if (strcmp(argv[1], command[i].name) == 0) return command[i].run(argc - 1, argv + 1);
  return command_follow(argc, argv);
}
