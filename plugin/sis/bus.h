/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Settings of the bus by service 0x03: TrS, TzA, Tmas and the baud rate (chapter 6). */

#ifndef SIS_BUS_H
#define SIS_BUS_H

#include "sertap/line.h"
#include "sis/body.h"

/* Instead of a station's address: valid for all. */
#define SIS_ALL_STATIONS 255

typedef enum { SIS_TRS, SIS_TZA, SIS_TMAS, SIS_BAUD, SIS_SETTINGS } sis_setting_kind_t;

typedef struct {
    uint32_t value;       /* ms or Bd */
    uint32_t set_in;      /* the command, or the event; 0: was not set */
    uint32_t accepted_in; /* 0: not yet */
    uint32_t order;       /* of all settings of the bus, in which they were told */
    bool is_by_user;      /* told by whoever captured, not on the bus */
} sis_setting_t;

/* What is valid for one station at one time. Never changed once made. */
typedef struct sis_settings {
    sis_setting_t of[SIS_SETTINGS];
} sis_settings_t;

/* First pass: takes a command or reaction of service 0x03. */
void sis_bus_learn(sis_body_t *body);

/* First pass: takes over what the user told of this bus. It counts for stations that the bus has told
 * nothing. */
void sis_bus_learn_limits(sis_bus_t *bus, const sertap_limits_t *limits);

/* First pass: what is valid for a station, or for all, now (ns since 1970); NULL if nothing was set. */
const sis_settings_t *sis_bus_settings(const sis_bus_t *bus, uint8_t address, int64_t now);

#endif
