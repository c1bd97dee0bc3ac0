/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Every code of the SIS documents and its text, and nothing else.
 *
 * These tables are the one source: the other languages of the project are checked against this file by a
 * test, which reads the lines between braces. Keep one entry a line. Chapters and figures are those of
 * DOK-GENERL-SIS-DEFINIT-IF02; "ECODRIVE03" is DOK-ECODR3-FGP-01VRS, fig. 1-7.
 */

#include "sis/names.h"

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

/* Kinds of addresses, fig. 2-9; the editions assign them to different addresses (address.c). */
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

/* The same byte in reactions of phase services (chapters 8.4 and 8.5): 2 has another meaning there, and 1
 * has none. */
const range_string sis_status_phase[] = {
    {0x01, 0x01, "Execution error, not specified for this service"},
    {0x02, 0x02, "Phase switching error"},
    {0, 0, NULL},
};

/* The error code after status 2, unless a service has another meaning for it, fig. 2-19. */
const value_string sis_errors_channel[] = {
    {0x8001, "Transmission channel busy"},
    {0x8002, "Fault in the transmission channel"},
    {0x800B, "Transmission cancelled, another request had priority"},
    {0x800C, "Access not allowed, the transmission channel is still active"},
    {0, NULL},
};

/* Subservices of 0x00, chapter 3. */
const value_string sis_subservices_identification[] = {
    {0x01, "SIS version"},
    {0x02, "Firmware (FWA) number"},
    {0x03, "Device type key"},
    {0x04, "Supported baud rates"},
    {0, NULL},
};

/* Subservices of 0x02, chapter 5. */
const value_string sis_subservices_flash[] = {
    {0x90, "Shutdown"},
    {0x91, "Reboot"},
    {0x92, "Read flash"},
    {0x93, "Find header"},
    {0x94, "Erase flash"},
    {0x96, "Program flash"},
    {0x97, "Build checksum"},
    {0x9F, "Reset errors in the slave"},
    {0, NULL},
};

/* Subservice and error byte of 0x02, chapter 5.3; those with 0x10 and 0x0B from the IndraDrive manual. */
const value_string sis_errors_flash[] = {
    {0x9002, "Firmware was deleted"},
    {0x9003, "Shutdown not allowed in phase 3"},
    {0x9004, "Shutdown not allowed in phase 4"},
    {0x9010, "Shutdown not allowed in operating mode"},
    {0x9102, "Firmware was deleted"},
    {0x9103, "Reboot not allowed in phase 3"},
    {0x9104, "Reboot not allowed in phase 4"},
    {0x9110, "Reboot not allowed in operating mode"},
    {0x9200, "Read error"},
    {0x920B, "More than the maximum of useful data"},
    {0x9400, "Timeout while erasing"},
    {0x940A, "Erasing is only possible in the loader"},
    {0x96E0, "Verify error while programming the flash"},
    {0x96E1, "Timeout while programming the flash"},
    {0x96FF, "Error while writing to the RAM"},
    {0x9701, "Additive checksum wrong"},
    {0x9702, "CRC32 checksum wrong"},
    {0, NULL},
};

/* Destination of Shutdown, chapter 5.1. */
const value_string sis_shutdown_targets[] = {
    {0, "Firmware"},
    {1, "Loader"},
    {0, NULL},
};

/* Device types of Program flash, chapter 5.1. */
const value_string sis_device_types[] = {
    {0, "None (not supported)"},
    {1, "ROM (not supported)"},
    {2, "RAM"},
    {3, "Dual-port RAM"},
    {4, "Flash"},
    {0, NULL},
};

/* Subservices of 0x03, chapter 6. */
const value_string sis_subservices_initialization[] = {
    {0x01, "Set TrS (slave reaction time)"},
    {0x02, "Set TzA (character interval)"},
    {0x03, "Set Tmas (master control word cycle)"},
    {0x06, "Assign multicast group"},
    {0x07, "Set baud rate"},
    {0x08, "Timed baud rate test"},
    {0xFF, "Accept the set values"},
    {0, NULL},
};

/* Subservice and error byte of 0x03, chapter 6.3. */
const value_string sis_errors_initialization[] = {
    {0x0700, "Baud rate not supported"},
    {0x0800, "Baud rate not supported"},
    {0x0801, "Test time too large for the internal timer"},
    {0, NULL},
};

/* Baud rate mask, fig. 3-10, 6-11 and 6-17. */
const value_string sis_baud_masks[] = {
    {0x00, "9600"}, {0x01, "19200"}, {0x02, "38400"}, {0x04, "57600"}, {0x08, "115200"}, {0, NULL},
};

/* Elements of a parameter, bits 3 to 5 of the parameter control, fig. 8-1. */
const value_string sis_elements[] = {
    {0, "Channel not active"},
    {1, "Ident number"},
    {2, "Name"},
    {3, "Attribute"},
    {4, "Unit"},
    {5, "Minimum"},
    {6, "Maximum"},
    {7, "Operating data"},
    {0, NULL},
};

/* Error codes of parameter services, fig. 8-48; 0x00A0 and 0x00B0 from SYNAX, 0x8002, 0x800B and
 * 0x800C from IndraDrive, whose manual has two meanings for the last. */
const value_string sis_errors_parameter[] = {
    {0x0000, "No error"},
    {0x0001, "Service channel not open"},
    {0x0009, "Wrong access to element 0"},
    {0x00A0, "Request not allowed"},
    {0x00B0, "Element not allowed"},
    {0x1001, "Ident number not available"},
    {0x1009, "Wrong access to element 1"},
    {0x2001, "Name not available"},
    {0x2002, "Name transmitted too short"},
    {0x2003, "Name transmitted too long"},
    {0x2004, "Name cannot be changed"},
    {0x2005, "Name is write-protected at present"},
    {0x3002, "Attribute transmitted too short"},
    {0x3003, "Attribute transmitted too long"},
    {0x3004, "Attribute cannot be changed"},
    {0x3005, "Attribute is write-protected at present"},
    {0x4001, "Unit not available"},
    {0x4002, "Unit transmitted too short"},
    {0x4003, "Unit transmitted too long"},
    {0x4004, "Unit cannot be changed"},
    {0x4005, "Unit is write-protected at present"},
    {0x5001, "Minimum not available"},
    {0x5002, "Minimum transmitted too short"},
    {0x5003, "Minimum transmitted too long"},
    {0x5004, "Minimum cannot be changed"},
    {0x5005, "Minimum is write-protected at present"},
    {0x6001, "Maximum not available"},
    {0x6002, "Maximum transmitted too short"},
    {0x6003, "Maximum transmitted too long"},
    {0x6004, "Maximum cannot be changed"},
    {0x6005, "Maximum is write-protected at present"},
    {0x7002, "Operating data transmitted too short"},
    {0x7003, "Operating data transmitted too long"},
    {0x7004, "Operating data cannot be changed"},
    {0x7005, "Operating data are write-protected at present"},
    {0x7006, "Operating data smaller than the minimum"},
    {0x7007, "Operating data greater than the maximum"},
    {0x7008, "Operating data not correct"},
    {0x700C, "Operating data outside the range: below zero, or above the modulo value of a modulo axis"},
    {0x700D, "The length of the operating data cannot be changed at present"},
    {0x700E, "The length of the operating data cannot be changed"},
    {0x700F, "List element not available, or the list offset is not the start of an element"},
    {0x8001, "Service channel busy"},
    {0x8002, "Failure in the service channel"},
    {0x800B, "Transmission cancelled, another request had priority"},
    {0x800C, "Service channel still active, or parameter occupied by a sequential transmission"},
    {0, NULL},
};

/* Error codes of a phase switch, fig. 8-49. */
const value_string sis_errors_phase[] = {
    {0x8004, "Wrong phase requested over the serial protocol"},
    {0xD005, "Phase switch still active"},
    {0xD006, "Phase switch not allowed while a drive is enabled"},
    {0xD007, "Phase switch not allowed while the master axis turns"},
    {0, NULL},
};

/* Phases with a mode, chapter 8.5. */
const value_string sis_phases[] = {
    {2, "parameter mode"},
    {4, "operating mode"},
    {0, NULL},
};

/* Data status of a command, bits 0 to 3, fig. 8-44. */
const value_string sis_data_states[] = {
    {0x0, "not set"},
    {0x3, "done"},
    {0x5, "interrupted"},
    {0x7, "in process"},
    {0xF, "execution not possible"},
    {0, NULL},
};

int sis_edition = SIS_EDITION_IF02;

/* ECODRIVE03 has no DISC: what follows is reserved there. */
#define FIRST_DISC    0xE0
#define LAST_RESERVED 0xFF

static const range_string *
service_entry(uint8_t service)
{
    int at = 0;

    if (sis_edition == SIS_EDITION_ECODRIVE03 && service >= FIRST_DISC)
        service = LAST_RESERVED;
    try_rval_to_str_idx(service, sis_services, &at); /* the ranges leave out no service */
    return &sis_services[at];
}

const char *
sis_service_range_name(uint8_t service)
{
    return service_entry(service)->strptr;
}

const char *
sis_service_name(wmem_allocator_t *scope, uint8_t service)
{
    const range_string *entry = service_entry(service);

    if (entry->value_min == entry->value_max)
        return entry->strptr;
    return wmem_strdup_printf(scope, "%s 0x%02x", entry->strptr, service);
}

const value_string *
sis_subservices_of(uint8_t service)
{
    switch (service) {
    case 0x00:
        return sis_subservices_identification;
    case 0x02:
        return sis_subservices_flash;
    case 0x03:
        return sis_subservices_initialization;
    default:
        return NULL;
    }
}

bool
sis_may_answer_subservice(uint8_t service, uint8_t asked, uint8_t answered)
{
    const value_string *defined = sis_subservices_of(service);

    return defined == NULL || asked == answered || try_val_to_str(answered, defined) == NULL;
}

bool
sis_service_is_reserved(uint8_t service)
{
    return strcmp(service_entry(service)->strptr, "Reserved service") == 0;
}
