/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Commands through routers: which command on one level became which on the next (chapter 2.2). First pass
 * only. */

#ifndef SIS_ROUTES_H
#define SIS_ROUTES_H

#include "sis/telegram.h"

struct sis_exchange; /* never looked into here */

/* Where a command waits; kept in what it belongs to. */
typedef struct {
    struct sis_route *route; /* NULL: it does not wait */
    wmem_list_frame_t *place;
} sis_waiting_t;

/* A command with subaddresses waits for what the next router makes of it. */
void sis_route_wait(sis_waiting_t *waiting, struct sis_exchange *exchange, tvbuff_t *tvb, packet_info *pinfo,
                    const sis_telegram_t *telegram);

/* The oldest command that waits and of which a router may have made this one. NULL: none. */
struct sis_exchange *sis_route_find(tvbuff_t *tvb, packet_info *pinfo, const sis_telegram_t *telegram);

/* A command was answered, or its master has sent the next one: it waits no longer, if it did. */
void sis_route_leave(sis_waiting_t *waiting);

void sis_routes_register(void);

#endif
