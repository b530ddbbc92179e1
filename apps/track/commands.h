/* commands.h: the commands of talus-track; each takes main's arguments from its own name on. */
#ifndef TRACK_COMMANDS_H
#define TRACK_COMMANDS_H

int command_follow(int argc, char **argv);
int command_calibrate(int argc, char **argv);
int command_lens(int argc, char **argv);
int command_tilt(int argc, char **argv);
int command_align(int argc, char **argv);

#endif
