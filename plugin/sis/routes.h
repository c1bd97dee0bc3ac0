/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Commands through routers: which command on one level became which on the next (chapter 2.2). First pass
 * only. */

#ifndef SIS_ROUTES_H
#define SIS_ROUTES_H

#include "sis/telegram.h"

struct sis_exchange; /* never looked into here */

/* The entry of a waiting command, part of its owner. */
typedef struct {
    struct sis_route *route; /* NULL: it does not wait */
    wmem_list_frame_t *place;
} sis_waiting_t;

/* Makes a command with subaddresses wait for the next router's version. */
void sis_route_wait(sis_waiting_t *waiting, struct sis_exchange *exchange, tvbuff_t *tvb, packet_info *pinfo,
                    const sis_telegram_t *telegram);

/* The oldest waiting command whose routed version this may be. NULL: none. */
struct sis_exchange *sis_route_find(tvbuff_t *tvb, packet_info *pinfo, const sis_telegram_t *telegram);

/* A command was answered, or its master has sent the next one: ends its wait, if any. */
void sis_route_leave(sis_waiting_t *waiting);

#endif
