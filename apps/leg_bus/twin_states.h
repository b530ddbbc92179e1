/* twin_states.h: the twin's drives as they count and what they measured, as the bus carries it. */
#ifndef TWIN_STATES_H
#define TWIN_STATES_H

#include "leg_bus.h"
#include "talus/experimental/twin.h"

/* Sensors and samples as the bus has them: each tick of the control is a sample, encoders of `bus`. */
void twin_states_settings(const struct model_bus *bus, tl_twin_settings *s);
/* The state frames of the last sample, `row`, knee first. zero_count: where the relative encoders stand at joint angle 0. */
void twin_states_pack(const tl_twin *b, const struct model_bus *bus, uint16_t counter,
                      const double row[TL_CHANNEL_COUNT], const double zero_count[TL_MAX_JOINTS],
                      struct leg_bus_frame frame[TL_MAX_JOINTS]);

#endif
