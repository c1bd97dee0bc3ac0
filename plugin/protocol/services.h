/* SPDX-License-Identifier: GPL-2.0-or-later */
/* What stands in the useful data of services.
 * Made by generate.py from services.toml: edit there. */
/* clang-format off */

#ifndef PROTOCOL_SERVICES_H
#define PROTOCOL_SERVICES_H

#include "protocol/fields.h"

typedef struct {
    uint8_t like; /* a general service with this layout; 0: it has its own */
    const compat_bool *condition; /* a preference that must be set; NULL: always */
    const value_string *subservices; /* after the device address, which is the first byte; NULL: it has none */
    bool has_status;  /* a reaction begins with a status byte */
    bool has_control; /* the useful data begin with control byte and device address */
} sis_service_t;

extern const sis_service_t sis_services_known[256];

#define SIS_LAYOUTS_IDENTIFICATION \
    {0x00, NULL, 4, (const sis_layout_t[]){ \
        {0x01, (const sis_item_t[]){{0}}, (const sis_item_t[]){{take_version, &hf_sis_version, NULL, 0, false}, {0}}}, \
        {0x02, (const sis_item_t[]){{0}}, (const sis_item_t[]){{take_firmware, &hf_sis_firmware, NULL, 0, false}, {0}}}, \
        {0x03, (const sis_item_t[]){{0}}, (const sis_item_t[]){{take_type_key, &hf_sis_type_key, NULL, 0, false}, {0}}}, \
        {0x04, (const sis_item_t[]){{0}}, (const sis_item_t[]){{take_init_baud_mask, &hf_sis_init_baud_mask, NULL, 1, false}, {0}}} }}

#define SIS_LAYOUTS_FLASH \
    {0x02, sis_errors_flash, 8, (const sis_layout_t[]){ \
        {0x90, (const sis_item_t[]){{NULL, &hf_sis_flash_target, sis_shutdown_targets, 1, false}, {take_flash_address, &hf_sis_flash_address, NULL, 4, false}, {0}}, (const sis_item_t[]){{0}}}, \
        {0x91, (const sis_item_t[]){{take_flash_address, &hf_sis_flash_address, NULL, 4, false}, {0}}, (const sis_item_t[]){{0}}}, \
        {0x92, (const sis_item_t[]){{take_flash_address, &hf_sis_flash_address, NULL, 4, false}, {take_flash_length, &hf_sis_flash_length, NULL, 1, false}, {0}}, (const sis_item_t[]){{take_data, &hf_sis_data, NULL, 0, false}, {0}}}, \
        {0x93, (const sis_item_t[]){{0}}, (const sis_item_t[]){{take_flash_address, &hf_sis_flash_address, NULL, 4, false}, {0}}}, \
        {0x94, (const sis_item_t[]){{take_flash_address, &hf_sis_flash_address, NULL, 4, false}, {take_flash_length, &hf_sis_flash_length, NULL, 4, false}, {0}}, (const sis_item_t[]){{0}}}, \
        {0x96, (const sis_item_t[]){{take_flash_address, &hf_sis_flash_address, NULL, 4, false}, {take_flash_device_type, &hf_sis_flash_device_type, sis_device_types, 1, false}, {take_data, &hf_sis_data, NULL, 0, false}, {0}}, (const sis_item_t[]){{0}}}, \
        {0x97, (const sis_item_t[]){{take_flash_address, &hf_sis_flash_address, NULL, 4, false}, {take_flash_length, &hf_sis_flash_length, NULL, 4, false}, {0}}, (const sis_item_t[]){{NULL, &hf_sis_flash_crc32, NULL, 4, true}, {0}}}, \
        {0x9F, (const sis_item_t[]){{0}}, (const sis_item_t[]){{0}}} }}

#define SIS_LAYOUTS_INITIALIZATION \
    {0x03, sis_errors_initialization, 6, (const sis_layout_t[]){ \
        {0x01, (const sis_item_t[]){{take_init_time, &hf_sis_init_time, NULL, 2, false}, {0}}, (const sis_item_t[]){{0}}}, \
        {0x02, (const sis_item_t[]){{take_init_time, &hf_sis_init_time, NULL, 2, false}, {0}}, (const sis_item_t[]){{0}}}, \
        {0x03, (const sis_item_t[]){{take_init_time, &hf_sis_init_time, NULL, 2, false}, {0}}, (const sis_item_t[]){{0}}}, \
        {0x07, (const sis_item_t[]){{take_init_baud_mask, &hf_sis_init_baud_mask, NULL, 1, false}, {0}}, (const sis_item_t[]){{0}}}, \
        {0x08, (const sis_item_t[]){{take_init_test_time, &hf_sis_init_test_time, NULL, 2, false}, {take_init_baud_mask, &hf_sis_init_baud_mask, NULL, 1, false}, {0}}, (const sis_item_t[]){{0}}}, \
        {0xFF, (const sis_item_t[]){{0}}, (const sis_item_t[]){{0}}} }}

/* Services that have no file, because their layouts say all; the last one is none. */
#define SIS_SERVICES_BY_LAYOUT \
    {0, NULL, 0, NULL}

#endif
