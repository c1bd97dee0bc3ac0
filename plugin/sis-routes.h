/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Commands through routers: which command on one level became which on the next (chapter 2.2). First pass
 * only. */

#ifndef SIS_ROUTES_H
#define SIS_ROUTES_H

#include "sis-exchange.h"

/* A command with subaddresses waits for what the next router makes of it. */
void
sis_route_wait(sis_exchange_t *exchange, tvbuff_t *tvb, packet_info *pinfo, const sis_telegram_t *telegram);

/* The oldest command that waits and of which a router may have made this one; it waits no longer. NULL: none.
 */
sis_exchange_t *sis_route_take(tvbuff_t *tvb, packet_info *pinfo, const sis_telegram_t *telegram);

/* A command was answered, or its master has sent the next one: it waits no longer, if it did. */
void sis_route_leave(sis_exchange_t *exchange);

void sis_routes_register(void);

#endif
