/* effect_link.h: models of the bodies beyond a transmission that is not rigid; internal to lib/. */
#ifndef TALUS_EFFECT_LINK_H
#define TALUS_EFFECT_LINK_H

#include "talus/experimental/effect.h"

/* Share of the joint's own inertia that turns with its motor, where neither the model tells them apart nor the
 * effect says: of the shank's at the knee (which holds the knee's reflected rotor), of all of a single joint's. */
#define TL_EFFECT_MOTOR_SHARE 0.4

/* without friction and offset, each torque that of its joint, and without the ankle's rotor */
tl_model tl_effect_bare_model(const tl_model *m);
/* A transmission with the change's linkage dimensions. TL_ERR_UNSUPPORTED where there is no linkage, but
 * for a change without any. Errors of tl_transmission_screw_linkage. */
TL_CHECK tl_status tl_effect_change_linkage(const tl_effect_change *c, const tl_transmission *t,
                                            tl_transmission *changed);

#endif
