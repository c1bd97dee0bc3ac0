/* SPDX-License-Identifier: GPL-2.0-or-later */
/* The codes of all protocols, and their texts.
 * Made by generate.py from codes.toml: edit there. */
/* clang-format off */

#ifndef PROTOCOL_CODES_H
#define PROTOCOL_CODES_H

#include "compat.h"

/* Fig. 2-9 and chapters 3 to 9. The first entry that fits names a service: single ones before their
 * ranges. */
extern const range_string sis_services[];

/* Kinds of addresses, fig. 2-9; the editions assign them to different addresses (address.c). */
typedef enum {
    SIS_STATION = 0,
    SIS_SERVICE_MASTER = 1,
    SIS_POINT_TO_POINT = 2,
    SIS_NOT_ASSIGNED = 3,
    SIS_RESERVED = 4,
    SIS_NO_SENDER = 5,
    SIS_GROUP = 6,
    SIS_LEVEL_BROADCAST = 7,
    SIS_GLOBAL_BROADCAST = 8,
} sis_address_kind_t;
extern const value_string sis_address_kinds[];

/* What a command of a service is, fig. 2-3: SEND writes, FETCH reads. Of 0x02 its subservice decides, of a
 * list (0x04) its elements. */
extern const value_string sis_command_kinds[];

/* What a command to several stations is, by the kind of its address, fig. 2-3. Nobody answers it. */
extern const value_string sis_message_kinds[];

/* Telegram control bits 7, 6, 5 of a reaction, ECODRIVE03; the order of the bits is inferred. */
extern const value_string sis_control_status_ecodrive03[];

/* Status byte of a reaction, fig. 2-18; 0xF9 to 0xFC from the IndraDrive manual. */
extern const range_string sis_status[];

/* The same byte in reactions of phase services (chapters 8.4 and 8.5): 2 has another meaning there, and 1
 * has none. */
extern const value_string sis_status_phase[];

/* The error code after status 2, unless a service has another meaning for it, fig. 2-19. */
extern const value_string sis_errors_channel[];

/* What to do after a code of the channel, fig. 2-19. */
extern const value_string sis_advice_channel[];

/* Subservices of 0x00, chapter 3. */
extern const value_string sis_subservices_identification[];

/* Subservices of 0x02, chapter 5. */
extern const value_string sis_subservices_flash[];

/* Subservice and error byte of 0x02, chapter 5.3; those with 0x10 and 0x0B from the IndraDrive manual. */
extern const value_string sis_errors_flash[];

/* Destination of Shutdown, chapter 5.1. */
extern const value_string sis_shutdown_targets[];

/* Device types of Program flash, chapter 5.1. */
extern const value_string sis_device_types[];

/* Subservices of 0x03, chapter 6. */
enum {
    SIS_SET_TRS = 0x01,
    SIS_SET_TZA = 0x02,
    SIS_SET_TMAS = 0x03,
    SIS_SET_BAUD_RATE = 0x07,
    SIS_TEST_BAUD = 0x08,
    SIS_ACCEPT = 0xFF,
};
extern const value_string sis_subservices_initialization[];

/* Subservice and error byte of 0x03, chapter 6.3. */
extern const value_string sis_errors_initialization[];

/* Baud rate mask, fig. 3-10, 6-11 and 6-17. */
extern const value_string sis_baud_masks[];

/* Elements of a parameter, bits 3 to 5 of the parameter control, fig. 8-1. */
extern const value_string sis_elements[];

/* Error codes of parameter services, fig. 8-48; 0x00A0 and 0x00B0 from SYNAX, 0x8002, 0x800B and 0x800C
 * from IndraDrive, whose manual has two meanings for the last. */
extern const value_string sis_errors_parameter[];

/* What else is said of an error code of parameter services, fig. 8-48. */
extern const value_string sis_advice_parameter[];

/* Error codes of a phase switch, fig. 8-49. */
extern const value_string sis_errors_phase[];

/* Phases with a mode, chapter 8.5. */
extern const value_string sis_phases[];

/* Data status of a command, bits 0 to 3, fig. 8-44. */
extern const value_string sis_data_states[];

/* Types of a parameter, fig. 8-3. */
extern const value_string sis_parameter_types[];

/* Length of a value, bits 16 to 18 of the attribute (IEC 61491). */
extern const value_string sis_attribute_lengths[];

/* Format of a value, bits 20 to 22 of the attribute (IEC 61491). */
typedef enum {
    SIS_FORMAT_BINARY = 0,
    SIS_FORMAT_UNSIGNED = 1,
    SIS_FORMAT_SIGNED = 2,
    SIS_FORMAT_HEXADECIMAL = 3,
    SIS_FORMAT_TEXT = 4,
    SIS_FORMAT_IDENT = 5,
    SIS_FORMAT_FLOATING = 6,
    SIS_FORMAT_TIME = 7,
} sis_format_t;
extern const value_string sis_attribute_formats[];

/* Types of a record of the tap. */
typedef enum {
    SERTAP_FRAME = 0,
    SERTAP_OTHER = 1,
    SERTAP_EVENT = 2,
    SERTAP_BEFORE = 3,
} sertap_type_t;
extern const value_string sis_sertap_types[];

/* Lines of a tap. */
extern const value_string sis_sertap_lines[];

/* Parity of a character. */
extern const value_string sis_sertap_parities[];

/* Stop bits of a character, in half bits. */
extern const value_string sis_sertap_stop_bits[];

/* How characters were cut into frames. */
extern const value_string sis_sertap_framings[];

/* Events of the tap. */
enum {
    SERTAP_CAPTURE_STARTED = 1,
    SERTAP_CHARACTERS_LOST = 3,
    SERTAP_ADAPTER_LOST = 4,
    SERTAP_LIMITS_TOLD = 6,
};
extern const value_string sis_sertap_events[];

/* Wireshark's states of a checksum. */
extern const value_string sis_checksum_states[];

/* Verdicts on a time with its uncertainty (chapter 10). */
typedef enum {
    SIS_TIME_OK = 0,
    SIS_TIME_EXCEEDED = 1,
    SIS_TIME_UNRESOLVED = 2,
} sis_verdict_t;
extern const value_string sis_verdicts[];

/* What a character or block of 3964R means, judged by what came before. */
typedef enum {
    P3964R_ASKS = 0,
    P3964R_BOTH_ASK = 1,
    P3964R_GRANTS = 2,
    P3964R_REFUSES_REQUEST = 3,
    P3964R_BLOCK = 4,
    P3964R_ACKNOWLEDGES = 5,
    P3964R_REFUSES_BLOCK = 6,
    P3964R_OUT_OF_PLACE = 7,
} p3964r_meaning_t;
extern const value_string sis_procedure_meanings[];

/* Characters of 3964R. */
enum {
    P3964R_STX = 0x02,
    P3964R_DLE = 0x10,
    P3964R_NAK = 0x15,
};
extern const value_string sis_procedure_characters[];

/* Verdicts on a time of 3964R. */
extern const value_string sis_procedure_verdicts[];

/* Commands on ARCNET (SYNAX chapter 7); an answer is a TO. */
enum {
    ARCNET7F_TO = 0,
    ARCNET7F_FETCH = 1,
};
extern const value_string sis_arcnet7f_commands[];

/* Data types on ARCNET (SYNAX p. 7-9, 7-10, 7-21). */
enum {
    ARCNET7F_WORD_ARRAY = 5,
};
extern const value_string sis_arcnet7f_types[];

/* Commands of RK512; Siemens alone has the last one. */
enum {
    RK512_SEND = 0x41,
    RK512_FETCH = 0x45,
};
extern const value_string sis_rk512_commands[];

/* Kinds of data of RK512; SYNAX has data blocks only. */
extern const value_string sis_rk512_kinds[];

/* Siemens' numbers; SYNAX' table is lost. */
extern const value_string sis_rk512_errors[];

/* First byte of a telegram of RK512. */
extern const value_string sis_rk512_telegrams[];

/* What is done with an object. */
typedef enum {
    SYNAXOBJ_READ_ANSWER = 0,
    SYNAXOBJ_WRITE_REQUEST = 1,
    SYNAXOBJ_READ_REQUEST = 2,
    SYNAXOBJ_WRITE_ANSWER = 3,
} synaxobj_operation_t;
extern const value_string sis_synaxobj_operations[];

/* Objects (SYNAX chapter 2). The last three control the multiplex channel (p. 2-15 and 5-5). Its control
 * word holds Index_out_c, Index_in_c and RR, its status word RA (p. 2-12): no document says which object
 * and which bits. */
enum {
    SYNAXOBJ_DIAGNOSIS_FIELDBUS = 0x5FF0,
    SYNAXOBJ_STATUS_FIELDBUS = 0x5FF2,
    SYNAXOBJ_FAULT_CODE_PPC = 0x5FF6,
};
extern const value_string sis_synaxobj_names[];

/* Services of Interbus PCP, as NIBA-01 prints them. */
extern const value_string sis_synaxpcp_services[];

/* Error class, code and additional code of Interbus PCP as one number, as NIBA-01 prints them. */
extern const value_string sis_synaxpcp_errors[];

/* Directions of process data. */
enum {
    SYNAXPD_TO_PPC = 1,
    SYNAXPD_FROM_PPC = 2,
};
extern const value_string sis_synaxpd_directions[];

/* Formats of the parameter channel (SYNAX chapter 3). The code of the short format 3 (p. 3-17) is not
 * known. */
enum {
    SYNAXPK_DRIVE_SHORT_1 = 0x00,
    SYNAXPK_A_SHORT_1 = 0x01,
    SYNAXPK_SIS_FORMAT = 0x0B,
};
extern const value_string sis_channel_formats[];

/* Who has sent a word of the parameter channel. */
enum {
    SYNAXPK_MASTER = 1,
    SYNAXPK_SLAVE = 2,
};
extern const value_string sis_channel_senders[];

/* Errors of the parameter channel itself (FLP p. 11-15); 0x1Fxx from SYNAX p. 3-21. */
extern const range_string sis_channel_codes[];

/* Lines of the ASCII protocol of ECODRIVE and IndraDrive, as MPH-02 (p. 10-86 to 10-91) and public clients
 * have them. */
typedef enum {
    SISASCII_TEXT = 0,
    SISASCII_OPEN = 1,
    SISASCII_PROMPT = 2,
    SISASCII_READ = 3,
    SISASCII_WRITE = 4,
    SISASCII_ELEMENT = 5,
    SISASCII_ASKS = 6,
    SISASCII_ERROR = 7,
    SISASCII_ECHO = 8,
    SISASCII_ANSWER = 9,
    SISASCII_END = 10,
} sisascii_kind_t;
extern const value_string sis_ascii_kinds[];

/* Errors that only the ASCII protocol has (MPH-02, fig. 10-51); the others are those of parameter
 * services. */
extern const value_string sis_errors_ascii[];

/* Names of parameters of axes (kind A, set 0), from SYNAX' interface manual. */
extern const value_string sis_parameters_a[];

/* Names of parameters of the control (kind C, set 0), from SYNAX' interface manual. Of C-0-0188 the rest
 * is cut off. */
extern const value_string sis_parameters_c[];

/* Data blocks of SYNAX200 that have a meaning of their own (chapters 7 and 8). */
enum {
    SYNAX_BLOCK_IO = 99,
    SYNAX_BLOCK_MODE = 100,
};
extern const range_string sis_synax_blocks[];

#endif
