/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Commands through routers: which command on one level became which on the next (chapter 2.2).
 *
 * A router drops the first address and sends the rest on. So a waiting command is kept under the bytes that
 * the next router would send. However many wait, one look then finds the command that a router has passed
 * on. */
#include "sis/routes.h"

#include "kept.h"
#include "parts.h"

/* The part that a router does not change: service, count of subaddresses on the level below, whether there
 * is a number, and all bytes from the sender's address on. Two sections of a capture are two plants. */
typedef struct {
    uint32_t section;
    uint32_t length; /* of the bytes, which follow */
    uint8_t layout[3];
    uint8_t bytes[257]; /* from the sender on, the longest telegram has no more */
} route_key_t;

#define KEY_SIZE(key) (offsetof(route_key_t, bytes) + (key)->length)

/* Commands that wait for the same telegram, oldest first. */
typedef struct sis_route {
    wmem_list_t *waiting;
    route_key_t *key;
} route_t;

static wmem_map_t *routes; /* those where a command waits, by key */

static unsigned
hash_key(const void *key)
{
    return wmem_strong_hash(key, KEY_SIZE((const route_key_t *)key));
}

static gboolean
are_keys_equal(const void *a, const void *b)
{
    const route_key_t *one = a, *other = b;

    return one->length == other->length && memcmp(one, other, KEY_SIZE(one)) == 0;
}

/* For a telegram from which a router has dropped this many addresses: 0, or 1 before it drops one. */
static route_key_t
make_key(tvbuff_t *tvb, packet_info *pinfo, const sis_telegram_t *telegram, unsigned dropped)
{
    unsigned begin = 6 + dropped; /* byte 6 is the sender's address */
    route_key_t key = {.section = compat_section(pinfo),
                       .length = telegram->declared - begin,
                       .layout = {telegram->service, telegram->subaddress_count - dropped,
                                  telegram->control & SIS_CONTROL_NUMBER}};

    tvb_memcpy(tvb, key.bytes, begin, key.length);
    return key;
}

static route_t *
new_route(const route_key_t *key)
{
    route_t *route = wmem_new(wmem_file_scope(), route_t);

    route->key = wmem_memdup(wmem_file_scope(), key, KEY_SIZE(key));
    route->waiting = wmem_list_new(wmem_file_scope());
    wmem_map_insert(routes, route->key, route);
    return route;
}

static void
free_route(route_t *route)
{
    wmem_map_remove(routes, route->key);
    wmem_destroy_list(route->waiting);
    wmem_free(wmem_file_scope(), route->key);
    wmem_free(wmem_file_scope(), route);
}

void
sis_route_wait(sis_waiting_t *waiting, struct sis_exchange *exchange, tvbuff_t *tvb, packet_info *pinfo,
               const sis_telegram_t *telegram)
{
    route_key_t key = make_key(tvb, pinfo, telegram, 1);
    route_t *route = wmem_map_lookup(routes, &key);

    if (route == NULL)
        route = new_route(&key);
    wmem_list_append(route->waiting, exchange);
    *waiting = (sis_waiting_t){route, wmem_list_tail(route->waiting)};
}

struct sis_exchange *
sis_route_find(tvbuff_t *tvb, packet_info *pinfo, const sis_telegram_t *telegram)
{
    route_key_t key;
    const route_t *route;

    if (wmem_map_size(routes) == 0)
        return NULL;
    key = make_key(tvb, pinfo, telegram, 0);
    route = wmem_map_lookup(routes, &key);
    return route != NULL ? wmem_list_frame_data(wmem_list_head(route->waiting)) : NULL;
}

void
sis_route_leave(sis_waiting_t *waiting)
{
    route_t *route = waiting->route;

    if (route == NULL)
        return;
    wmem_list_remove_frame(route->waiting, waiting->place);
    if (wmem_list_count(route->waiting) == 0)
        free_route(route);
    waiting->route = NULL;
}

void
sis_routes_register(void)
{
    routes = kept_map(hash_key, are_keys_equal);
}
