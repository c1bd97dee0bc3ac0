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
        {0x01, {{0}}, {{take_version, &hf_sis_version, NULL, 0, false}}}, \
        {0x02, {{0}}, {{take_firmware, &hf_sis_firmware, NULL, 0, false}}}, \
        {0x03, {{0}}, {{take_type_key, &hf_sis_type_key, NULL, 0, false}}}, \
        {0x04, {{0}}, {{take_init_baud_mask, &hf_sis_init_baud_mask, NULL, 1, false}}} }}

#define SIS_LAYOUTS_FLASH \
    {0x02, sis_errors_flash, 8, (const sis_layout_t[]){ \
        {0x90, {{NULL, &hf_sis_flash_target, sis_shutdown_targets, 1, false}, {take_flash_address, &hf_sis_flash_address, NULL, 4, false}}, {{0}}}, \
        {0x91, {{take_flash_address, &hf_sis_flash_address, NULL, 4, false}}, {{0}}}, \
        {0x92, {{take_flash_address, &hf_sis_flash_address, NULL, 4, false}, {take_flash_length, &hf_sis_flash_length, NULL, 1, false}}, {{take_data, &hf_sis_data, NULL, 0, false}}}, \
        {0x93, {{0}}, {{take_flash_address, &hf_sis_flash_address, NULL, 4, false}}}, \
        {0x94, {{take_flash_address, &hf_sis_flash_address, NULL, 4, false}, {take_flash_length, &hf_sis_flash_length, NULL, 4, false}}, {{0}}}, \
        {0x96, {{take_flash_address, &hf_sis_flash_address, NULL, 4, false}, {take_flash_device_type, &hf_sis_flash_device_type, sis_device_types, 1, false}, {take_data, &hf_sis_data, NULL, 0, false}}, {{0}}}, \
        {0x97, {{take_flash_address, &hf_sis_flash_address, NULL, 4, false}, {take_flash_length, &hf_sis_flash_length, NULL, 4, false}}, {{NULL, &hf_sis_flash_crc32, NULL, 4, true}}}, \
        {0x9F, {{0}}, {{0}}} }}

#define SIS_LAYOUTS_INITIALIZATION \
    {0x03, sis_errors_initialization, 6, (const sis_layout_t[]){ \
        {0x01, {{take_init_time, &hf_sis_init_time, NULL, 2, false}}, {{0}}}, \
        {0x02, {{take_init_time, &hf_sis_init_time, NULL, 2, false}}, {{0}}}, \
        {0x03, {{take_init_time, &hf_sis_init_time, NULL, 2, false}}, {{0}}}, \
        {0x07, {{take_init_baud_mask, &hf_sis_init_baud_mask, NULL, 1, false}}, {{0}}}, \
        {0x08, {{take_init_test_time, &hf_sis_init_test_time, NULL, 2, false}, {take_init_baud_mask, &hf_sis_init_baud_mask, NULL, 1, false}}, {{0}}}, \
        {0xFF, {{0}}, {{0}}} }}

/* Services that have no file, because their layouts say all; the last one is none. */
#define SIS_SERVICES_BY_LAYOUT \
    {0, NULL, 0, NULL}

#endif
