/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Every code of the SIS documents and its text, and nothing else.
 *
 * These tables are the one source: the other languages of the project are checked against this file by a
 * test, which reads the lines between braces. Keep one entry a line. Chapters and figures are those of
 * DOK-GENERL-SIS-DEFINIT-IF02; "ECODRIVE03" is DOK-ECODR3-FGP-01VRS, fig. 1-7.
 */

#include "sis-names.h"

/* Fig. 2-9 and chapters 3 to 9. The first entry that fits names a service: single ones before their ranges.
 */
const range_string sis_services[] = {
    {0x00, 0x00, "Node identification"},
    {0x01, 0x01, "Cancel data transmission"},
    {0x02, 0x02, "Flash operation"},
    {0x03, 0x03, "Initialization of the SIS communication"},
    {0x04, 0x04, "Execute a list of SIS services"},
    {0x0F, 0x0F, "Token passing"},
    {0x10, 0x10, "Read parameter"},
    {0x11, 0x11, "Read list segment"},
    {0x12, 0x12, "Read phase"},
    {0x1D, 0x1D, "Switch phase"},
    {0x1E, 0x1E, "Write list segment"},
    {0x1F, 0x1F, "Write parameter"},
    {0x80, 0x80, "Read parameter (ECODRIVE)"},
    {0x81, 0x81, "Read list segment (ECODRIVE)"},
    {0x8E, 0x8E, "Write list segment (ECODRIVE)"},
    {0x8F, 0x8F, "Write parameter (ECODRIVE)"},
    {0x90, 0x90, "Read parameter (SYNAX)"},
    {0x91, 0x91, "Read list segment (SYNAX)"},
    {0x92, 0x92, "Read phase (SYNAX)"},
    {0x9D, 0x9D, "Switch phase (SYNAX)"},
    {0x9E, 0x9E, "Write list segment (SYNAX)"},
    {0x9F, 0x9F, "Write parameter (SYNAX)"},
    {0x00, 0x0F, "General service"},
    {0x10, 0x7F, "Reserved service"},
    {0x80, 0x8F, "ECODRIVE service"},
    {0x90, 0x9F, "SYNAX service"},
    {0xA0, 0xAF, "MT-CNC/MTC200 service"},
    {0xB0, 0xBF, "ISP200 service"},
    {0xC0, 0xCF, "CLC-GPS service"},
    {0xD0, 0xDF, "HMI system service"},
    {0xE0, 0xEF, "DISC service"},
    {0xF0, 0xFF, "Reserved service"},
    {0, 0, NULL},
};

/* Kinds of addresses, fig. 2-9; which address is of which kind differs between the editions (sis-address.c).
 */
const value_string sis_address_kinds[] = {
    {SIS_STATION, "station"},
    {SIS_SERVICE_MASTER, "service or emergency master"},
    {SIS_POINT_TO_POINT, "point-to-point"},
    {SIS_NOT_ASSIGNED, "not assigned"},
    {SIS_RESERVED, "reserved"},
    {SIS_NO_SENDER, "not a sender address"},
    {SIS_GROUP, "logical group"},
    {SIS_LEVEL_BROADCAST, "broadcast on one hierarchy level"},
    {SIS_GLOBAL_BROADCAST, "global broadcast"},
    {0, NULL},
};

/* Telegram control bits 7, 6, 5 of a reaction, ECODRIVE03; the order of the bits is inferred. */
const value_string sis_control_status_ecodrive03[] = {
    {0, "No error, request processed"},
    {1, "Request still being processed"},
    {2, "Request cannot be processed now"},
    {3, "Not defined"},
    {4, "Warning"},
    {5, "Not defined"},
    {6, "Error"},
    {7, "Not defined"},
    {0, NULL},
};

/* Status byte of a reaction, fig. 2-18; 0xF9 to 0xFC from the IndraDrive manual. */
const range_string sis_status[] = {
    {0x00, 0x00, "Transmission error-free"},
    {0x01, 0x01, "Execution error"},
    {0x02, 0x02, "Error in the internal transmission channel"},
    {0x03, 0xEF, "Execution error, not specified"},
    {0xF0, 0xF0, "Invalid service"},
    {0xF1, 0xF1, "Invalid telegram"},
    {0xF2, 0xF2, "Wrong telegram length"},
    {0xF3, 0xF3, "Telegram error, not specified"},
    {0xF4, 0xF4, "Wrong checksum"},
    {0xF5, 0xF7, "Telegram error, not specified"},
    {0xF8, 0xF8, "Invalid sequential telegram"},
    {0xF9, 0xF9, "Command has subaddresses, the slave does not route"},
    {0xFA, 0xFA, "Useful data missing in the command"},
    {0xFB, 0xFB, "Subservice not supported"},
    {0xFC, 0xFC, "Component not available or address invalid"},
    {0xFD, 0xFF, "Telegram error, not specified"},
    {0, 0, NULL},
};

/* The same byte where it answers a phase service (chapters 8.4 and 8.5): 2 has another meaning there, and 1
 * has none. */
const range_string sis_status_phase[] = {
    {0x01, 0x01, "Execution error, not specified for this service"},
    {0x02, 0x02, "Phase switching error"},
    {0, 0, NULL},
};

static const range_string *
service_entry(uint8_t service)
{
    int index = 0;

    try_rval_to_str_idx(service, sis_services, &index); /* the ranges leave out no service */
    return &sis_services[index];
}

const char *
sis_service_name(wmem_allocator_t *scope, uint8_t service)
{
    const range_string *entry = service_entry(service);

    if (entry->value_min == entry->value_max)
        return entry->strptr;
    return wmem_strdup_printf(scope, "%s 0x%02x", entry->strptr, service);
}

bool
sis_service_is_reserved(uint8_t service)
{
    return strcmp(service_entry(service)->strptr, "Reserved service") == 0;
}
